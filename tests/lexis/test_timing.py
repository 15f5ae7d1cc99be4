import pytest

from lexis.timing import StageTimer


def test_stages_add_up_in_the_order_of_their_first_use():
    timed = StageTimer()
    for stage in ("encode", "verify", "encode"):
        before = timed.seconds.get(stage, 0.0)
        with timed(stage):
            pass
        assert timed.seconds[stage] > before
    assert list(timed.seconds) == ["encode", "verify"]


def test_a_stage_that_fails_is_counted_and_the_error_goes_on():
    timed = StageTimer()
    with pytest.raises(KeyError), timed("encode"):
        raise KeyError
    assert "encode" in timed.seconds
