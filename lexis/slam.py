"""The LEXIS pipeline, from observations to a map. Start reading here.

These are the stages, in the order in which they run (with the sections of the paper). Stages 4 to 8 work on keyframes alone:

1. Select keyframes, and support frames between them that help to triangulate (`lexis.keyframes`, III-A). Equal spacing makes
   the graph grow with the path and not with time. All other observations are dropped.
2. Encode the images of keyframes, and extract local features from those of all selected frames (`lexis.perception`, III-A),
   for each camera of the rig by itself. The embeddings are used to find the room label and loop candidates, the features to
   verify loops.
3. Triangulate the landmarks of each keyframe from the frames around it (`lexis.keyframe_window`), because PnP needs 3-D
   points.
4. Add the keyframe to the pose graph (`lexis.graph`, III-A), at the pose that odometry predicts.
5. Propose loop candidates (`lexis.place_recognition`, III-D): earlier keyframes that the robot probably revisits, by the
   similarity of the images and by the estimated poses. The paper instead proposes keyframes of the room in the image.
6. Verify the candidates by PnP and add the confirmed loops as edges (`lexis.verification`, III-D), because two images of
   one room need not show the same place.
7. Optimise the graph when loops have been added (`lexis.graph`, Eq. 2), which removes odometry drift.
8. Label all keyframes, refine the labels, and cluster keyframes into rooms and floors (`lexis.semantics`, III-B and III-C).
   This happens when a map is made, because the result depends on all poses. If loops are searched by room, as in the paper,
   it also happens while the map grows.

`Slam.process`, `Slam._add` and `Slam._map` call these stages. The rest of the class is about long runs and several sessions:

- A keyframe retires from the optimisation when several earlier keyframes show its place. It then follows one of them, its
  anchor, whose images also stand for its own (`lexis.graph.thinning`).
- With an earlier map, the keyframes are a further session of this map. Its place in the map is unknown at first, so that the
  map is split into components, until loops join them (`lexis.sessions.relocalisation`).
- A robot may be carried elsewhere without noticing it. Its loops to earlier places are then far from the estimate, and the
  finished map is corrected if many of them agree (`lexis.sessions.kidnapping`).
"""

from collections.abc import Sequence
from copy import copy

from lexis.config import Config
from lexis.errors import LexisError
from lexis.features import FeatureExtractor
from lexis.graph.components import session_components, side_by_side
from lexis.graph.far_loops import shifts_of
from lexis.graph.loop_record import LoopRecord
from lexis.graph.pose_graph import KnownPlace, PoseGraph
from lexis.inputs import check_camera, check_observation, check_room_names, with_copied_geometry
from lexis.keyframe_window import KeyframeWindow
from lexis.keyframes import KeyframeSelector
from lexis.map.encoder_check import check_embedding_size
from lexis.maths.growing_array import GrowingArray
from lexis.perception import Encoder, check_room_embeddings, embedding_of, features_of
from lexis.place_recognition import PlaceRecogniser, propose
from lexis.room_labels import most_similar, similarities
from lexis.semantics import Labeller, Semantics, Views, derive_by_component
from lexis.sessions.compatibility import check_continues
from lexis.sessions.kidnapping import find_kidnapping, strongest
from lexis.sessions.relocalisation import Relocaliser, at_any_distance, candidates_elsewhere, without_support
from lexis.sessions.renumbered_map import RenumberedMap
from lexis.sight.visible_space import VisibleSpace, spaces_in_view
from lexis.timing import StageTimer
from lexis.types import Camera, EncoderId, Keyframe, LexisMap, LoopDecision, LoopEdge, Observation, Poses, RoomInstance
from lexis.verification import Verification, Verifier, verify


class Slam:
    """Builds a map from a sequence of observations.

    Example::

        slam = Slam(camera, encoder, ("kitchen", "office", "corridor", "stairs"))
        for observation in observations:
            slam.process(observation)
        lexis_map = slam.finish()
    """

    def __init__(
        self,
        camera: Camera,
        encoder: Encoder,
        room_names: Sequence[str],
        config: Config | None = None,
        verifier: Verifier = verify,
        place_recogniser: PlaceRecogniser = propose,
        labeller: Labeller | None = None,
        *,
        map: LexisMap | None = None,
    ) -> None:
        """Set up all stages and encode the room prompts.

        The arguments `verifier`, `place_recogniser` and `labeller` each replace a stage: verification, place recognition, or
        the labelling before keyframes are clustered into rooms. A test can thus replace one stage by the truth. With `map`,
        the observations are a new session of this map; the result contains all sessions.

        Raises:
            LexisError: the camera or the room names are unusable, or the camera, the room names or the encoder differ from
                those of `map`.
            EncoderError: the encoder does not give one embedding of unit norm for each room name.
        """
        check_camera(camera)
        check_room_names(room_names)
        self._camera = camera.copy()
        self._encoder = encoder
        self._room_names = tuple(room_names)
        self._config = config or Config()
        self._verify, self._propose, self._labeller = verifier, place_recogniser, labeller
        self._text = encoder.encode_rooms(self._room_names)
        check_room_embeddings(self._text, len(self._room_names), encoder)
        self._extractor = FeatureExtractor(self._config.landmarks)
        self._graph = PoseGraph(self._config.pose_graph, self._camera)
        self._similarities = GrowingArray((len(camera.rig), len(self._room_names)))
        self._spaces: list[tuple[VisibleSpace, ...]] = []
        self._record = LoopRecord()
        self._forgotten = 0
        """Number of retired keyframes whose spaces and records have been dropped."""
        self._rooms: tuple[RoomInstance, ...] = ()
        self._previous: Observation | None
        self._selector: KeyframeSelector
        self._timed = StageTimer()
        self._relocaliser = Relocaliser(self._config.sessions, self._config.verification)
        if map is not None:
            check_continues(map, camera, encoder, room_names)
            check_embedding_size(map, self._text)
            self._resume(map)
        self._begin_session()

    def process(self, observation: Observation) -> None:
        """Process the next observation. A keyframe enters the graph only once the frames after it have arrived.

        The caller may reuse the arrays of the observation, because they are not read after this method returns.

        Raises:
            ObservationError: the observation does not fit the camera or the sequence.
            EncoderError: the encoder gives no embedding of unit norm for an image, or one of another length than for room
                names. The observation then counts as not processed: it can be passed again, or left out.
        """
        check_observation(observation, self._camera, self._previous, self._text.shape[1])
        observation = with_copied_geometry(observation)
        selector = copy(self._selector)
        frame = selector.select(observation)
        embeddings = None
        if frame is not None and frame.is_keyframe:
            with self._timed("encode"):
                embeddings = [embedding_of(image, self._encoder, self._text.shape[1]) for image in observation.images]
        self._previous, self._selector = observation, selector  # not earlier, because the encoder may raise an error
        if frame is None:
            return
        with self._timed("features"):
            features = [features_of(image, self._extractor) for image in observation.images]
        with self._timed("landmarks"):
            complete = self._window.add(frame, features, embeddings)
        for keyframe in complete:
            self._add(keyframe)

    def replay(self, map: LexisMap) -> None:
        """Add the keyframes of another map, in place of observations.

        The sessions of the other map are numbered after the sessions of this map. Its retired keyframes stay retired, and
        sessions that it has joined stay joined. Observations that follow begin a new session.

        Raises:
            MapError: the other map has another encoder, other room names or other cameras.
            LexisError: observations were processed, and their last keyframes still wait for later ones.
        """
        check_continues(map, self._camera, self._encoder, self._room_names)
        check_embedding_size(map, self._text)
        if not self._window.is_empty:
            raise LexisError(
                "the last keyframes still wait for later observations; valid: finish() first, or replay() in another Slam"
            )
        self._begin_session()
        other = RenumberedMap(map, self.keyframe_count, self._window.session)
        for id in range(len(map.keyframes)):
            keyframe, place = other.keyframe(id), other.place(id)
            if keyframe.anchor is None:
                self._add(keyframe, place, other.loops(id), other.decisions(id))
            else:
                assert place is not None
                self._graph.add_retired(keyframe, place.T_beside_B)
                self._graph.add_loops(other.loops(id))
                self._take_views(self._graph.keyframes[-1])
        self._begin_session()

    def snapshot(self) -> LexisMap:
        """Return the map so far. The last keyframes, which still wait for frames, are left out; the run can go on.

        Raises:
            LexisError: there is no keyframe yet.
        """
        if not self._graph.keyframes:
            raise LexisError("there is no keyframe yet; valid: a snapshot when `keyframe_count` is at least 1")
        return self._map()

    @property
    def is_split(self) -> bool:
        """Whether the map has several components, because a session has not been recognised in the others so far."""
        return self._graph.is_split

    @property
    def keyframe_count(self) -> int:
        """Number of keyframes in the graph, those of an earlier map included."""
        return len(self._graph.keyframes)

    def finish(self) -> LexisMap:
        """Complete the last keyframes without the frames they were waiting for, and return the map of all sessions.

        If the robot was carried elsewhere, this corrects the map; snapshots are not corrected.

        Raises:
            LexisError: there is no keyframe, neither of an observation nor of an earlier map.
        """
        with self._timed("landmarks"):
            complete = self._window.flush()
        for keyframe in complete:
            self._add(keyframe)
        if not self._graph.keyframes:
            raise LexisError("no observation was processed; valid: at least one before finish()")
        self._optimise(final=True)
        self._correct_kidnapping()
        return self._map()

    def _begin_session(self) -> None:
        """Prepare for the observations of a new session, which follows all sessions of the graph."""
        session = self._graph.keyframes[-1].session + 1 if self._graph.keyframes else 0
        self._window = KeyframeWindow(self._camera, self._config, self.keyframe_count, session)
        self._selector = KeyframeSelector(self._config.keyframes)
        self._previous = None

    def _resume(self, map: LexisMap) -> None:
        """Fill the graph with the keyframes, poses and loops of an earlier map."""
        components = session_components(map.keyframes, map.loops)
        self._graph.resume(map.keyframes, map.T_W_B, map.loops, components)
        for keyframe in map.keyframes:
            self._take_views(keyframe)
        self._record.resume(map.candidates, map.decisions)

    def _add(
        self,
        keyframe: Keyframe,
        place: KnownPlace | None = None,
        loops: Sequence[LoopEdge] = (),
        decisions: Sequence[LoopDecision] = (),
    ) -> None:
        """Add a keyframe to the graph, and close its loops. In a replay, its place and some of its loops may be known.

        Before the map is finished, rooms are needed only if loops are searched by room, as in the paper. They are then
        derived after every `labels.every` keyframes and after every optimisation. Deriving them after every keyframe would
        be slow, because all keyframes are labelled each time.
        """
        self._graph.add_keyframe(keyframe, place)
        self._take_views(keyframe)
        verified = self._close_loops(keyframe)
        if loops:
            self._keep_loops(loops, decisions, verified)
        joined = self._join_components(keyframe)
        optimised = self._optimise() or joined
        due = optimised or len(self._graph.keyframes) % self._config.labels.every == 0
        if due and self._config.place_recognition.method == "room":
            self._rooms = self._derive_semantics(self._graph.T_W_B).rooms

    def _take_views(self, keyframe: Keyframe) -> None:
        """Store what labels are derived from: how the images of a keyframe resemble the room names, and what they show."""
        self._similarities.append(similarities(keyframe.embeddings, self._text))
        if self._config.by_sight:
            self._spaces.append(spaces_in_view(keyframe, self._camera, self._config.sight))

    def _derive_semantics(self, T_W_B: Poses) -> Semantics:
        """Derive labels, rooms and floors of all keyframes at the given poses."""
        with self._timed("rooms"):
            given = self._labeller(self._graph.keyframes) if self._labeller else None
            shown = self._similarities.rows[self._graph.shown_by]
            views = Views(shown, self._spaces, T_W_B, self._camera, self._graph.sessions)
            return derive_by_component(views, self._graph.components, self._room_names, self._config, given)

    def _close_loops(self, query: Keyframe) -> Verification:
        """Propose loop candidates, verify them by PnP, and add the loop edges. Returns the edges and the decisions."""
        with self._timed("propose"):
            label = self._room_names[most_similar(self._similarities.rows[query.id].mean(axis=0))]
            candidates = self._propose(query, label, self._rooms, self._graph, self._config.place_recognition)
        with self._timed("verify"):
            verified = self._verify(query, candidates, self._graph, self._camera, self._config.verification)
        self._record.add(query.id, candidates, verified.decisions)
        self._graph.add_loops(verified.edges)
        self._graph.add_far_loops(query.id, candidates, verified.far)
        return verified

    def _keep_loops(self, loops: Sequence[LoopEdge], decisions: Sequence[LoopDecision], verified: Verification) -> None:
        """Add known loops of the last keyframe that were not found again, and the decisions on them.

        `verified` are the loops that were found, and their decisions.
        """
        found, judged = ({one.match for one in ones} for ones in (verified.edges, verified.decisions))
        kept = [loop for loop in loops if loop.match not in found]
        known = [decision for decision in decisions if decision.match not in judged]
        self._graph.add_loops(kept)
        self._record.accept(kept)
        self._record.add(loops[0].query, [decision.match for decision in known], known)

    def _join_components(self, query: Keyframe) -> bool:
        """Seek the place of a keyframe in the components of the map that are not connected with its own.

        Returns whether two components have been joined. The graph has been optimised then.
        """
        if not self._graph.is_split:
            return False
        with self._timed("relocalise"):
            candidates = candidates_elsewhere(query, self._graph, self._config.sessions)
            settings = at_any_distance(self._config.verification)
            found = self._verify(query, candidates, self._graph, self._camera, settings)
            agreed = self._relocaliser.agreed(found.edges, self._graph)
        self._record.add(query.id, candidates, without_support(found.decisions))
        if not agreed:
            return False
        self._record.accept(agreed)
        self._graph.join(agreed, shifts_of(agreed[-1:], self._graph.T_W_B)[0])
        self._optimise(final=True)
        return True

    def _correct_kidnapping(self) -> None:
        """Move the last keyframes to where the robot was carried, if loops agree on it."""
        agreeing, verification = self._config.sessions.kidnapping_agreeing, self._config.verification
        if agreeing is None:
            return
        with self._timed("optimise"):
            found = find_kidnapping(self._graph, agreeing, verification)
        if found is None:
            return
        loops = strongest(found.loops, verification.max_edges)
        self._record.accept(loops)
        self._graph.displace(found.step, found.shift, loops)
        self._optimise(final=True)

    def _optimise(self, final: bool = False) -> bool:
        with self._timed("optimise"):
            optimised = self._graph.optimise_if_due(final)
        self._forget_retired()
        return optimised

    def _forget_retired(self) -> None:
        """Forget what keyframes that have retired showed, and the loops that they sought; see `lexis.graph.thinning`."""
        new = self._graph.retired[self._forgotten :].tolist()
        if not new:
            return
        self._forgotten += len(new)
        if self._spaces:
            for id in new:
                self._spaces[id] = spaces_in_view(self._graph.keyframes[id], self._camera, self._config.sight)
        self._record.forget(new)

    def _map(self) -> LexisMap:
        T_W_B = side_by_side(self._graph.T_W_B, self._graph.components)
        semantics = self._derive_semantics(T_W_B)
        return LexisMap(
            camera=self._camera,
            encoder=EncoderId(self._encoder.name, self._encoder.fingerprint),
            room_names=self._room_names,
            keyframes=tuple(self._graph.keyframes),
            T_W_B=T_W_B,
            **vars(semantics),
            loops=tuple(self._graph.loops),
            loop_weights=self._graph.loop_weights,
            candidates=self._record.candidates,
            decisions=self._record.decisions,
            stage_seconds=dict(self._timed.seconds),
        )
