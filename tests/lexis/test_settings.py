"""Settings refuse what their annotations exclude, and go to plain data and back."""

import json
import math
from dataclasses import dataclass, field, fields, is_dataclass
from typing import Annotated, Literal, get_origin, get_type_hints

import numpy as np
import pytest
from annotated_types import Ge, Gt, Interval, MinLen

from lexis.config import Config, KeyframeConfig, read_config
from lexis.errors import ConfigError
from lexis.settings import Settings, changed_settings, settings_data, settings_of


@dataclass(frozen=True)
class Inner(Settings, place="inner", error=ConfigError):
    speed_m_s: Annotated[float, Gt(0)] = 0.7
    laps: Annotated[int, Ge(1)] = 3


@dataclass(frozen=True)
class Outer(Settings, place="outer", error=ConfigError):
    gait: Literal["walk", "run"] = "walk"
    share: Annotated[float, Interval(gt=0, le=1)] = 0.5
    length_m: Annotated[float, Gt(0)] | None = None
    name: Annotated[str, MinLen(1)] = "somebody"
    loud: bool = False
    inner: Inner = field(default_factory=Inner)


@pytest.mark.parametrize(
    ("kind", "name", "value", "valid"),
    [
        (Inner, "speed_m_s", 0.0, "> 0 m/s"),
        (Inner, "speed_m_s", float("nan"), "a finite number > 0 m/s"),
        (Inner, "speed_m_s", float("inf"), "a finite number > 0 m/s"),
        (Inner, "speed_m_s", "fast", "a finite number > 0 m/s"),
        (Inner, "speed_m_s", None, "a finite number > 0 m/s"),
        (Inner, "speed_m_s", True, "a finite number > 0 m/s"),
        (Inner, "laps", 2.0, "a whole number >= 1"),
        (Inner, "laps", 0, ">= 1"),
        (Inner, "laps", 10**400, ">= 1"),
        (Inner, "speed_m_s", 10**400, "a finite number > 0 m/s"),
        (Outer, "gait", "hop", "walk, run"),
        (Outer, "share", 0.0, "> 0 and <= 1"),
        (Outer, "share", 1.01, "> 0 and <= 1"),
        (Outer, "length_m", -1.0, "> 0 m, or null (None in Python)"),
        (Outer, "name", "", "a text that is not empty"),
        (Outer, "name", 7, "a text that is not empty"),
        (Outer, "loud", 1, "true or false"),
    ],
)
def test_what_an_annotation_excludes_is_refused_by_name(kind, name, value, valid):
    with pytest.raises(ConfigError) as caught:
        kind(**{name: value})
    assert str(caught.value) == f"{kind.place}.{name} is {value!r}; valid: {valid}"


@pytest.mark.parametrize(
    ("kind", "name", "value"),
    [(Inner, "speed_m_s", 1), (Inner, "laps", np.int64(2)), (Outer, "share", np.float64(1.0)), (Outer, "length_m", 3)],
)
def test_numbers_of_every_type_are_numbers(kind, name, value):
    settings = kind(**{name: value})
    assert getattr(settings, name) == value
    assert settings_of(kind, json.loads(json.dumps(settings_data(settings)))) == settings


def test_data_and_back():
    settings = Outer("run", 0.25, 12.0, "x", True, Inner(2.0, 7))
    assert settings_of(Outer, json.loads(json.dumps(settings_data(settings)))) == settings
    assert settings_of(Outer, {"inner": {"laps": 5}}) == Outer(inner=Inner(laps=5))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ({"gate": "walk"}, "file: outer has no setting 'gate'; valid: gait, share"),
        ({"inner": {"lap": 1}}, "file: inner has no setting 'lap'; valid: speed_m_s, laps"),
        ({"inner": {"laps": 0}}, "file: inner.laps is 0; valid: >= 1"),
        ({"inner": {"laps": 1.5}}, "file: inner.laps is 1.5; valid: a whole number >= 1"),
        ({"inner": {"laps": "2"}}, "file: inner.laps is '2'; valid: a whole number >= 1"),
        ({"inner": {"speed_m_s": math.inf}}, "file: inner.speed_m_s is inf; valid: a finite number > 0 m/s"),
        ({"inner": {"speed_m_s": 10**400}}, f"file: inner.speed_m_s is {10**400}; valid: a finite number > 0 m/s"),
        ({"inner": {"laps": 10**400}}, f"file: inner.laps is {10**400}; valid: >= 1"),
        ({"inner": 3}, "file: inner is 3; valid: names of settings"),
        ([], "file: outer is []; valid: names of settings"),
    ],
)
def test_bad_data_names_the_file_and_the_setting(data, message):
    with pytest.raises(ConfigError) as caught:
        settings_of(Outer, data, "file")
    assert str(caught.value).startswith(message)


def test_every_number_of_lexis_declares_its_range():
    for stage in fields(Config):
        for name, hint in get_type_hints(stage.default_factory, include_extras=True).items():
            choice = hint is bool or get_origin(hint) is Literal
            declared = choice or hasattr(hint, "__metadata__") or any(hasattr(o, "__metadata__") for o in hint.__args__)
            assert declared or name in ("place", "error"), f"{stage.name}.{name}"
        assert is_dataclass(stage.default_factory) and stage.default_factory.place == stage.name


def test_a_file_of_settings(tmp_path):
    file = tmp_path / "settings.json"
    file.write_text(json.dumps({"keyframes": {"spacing_m": 0.75}}))
    assert read_config(file) == Config(keyframes=KeyframeConfig(spacing_m=0.75))
    file.write_text(json.dumps({"keyframes": {"spacing": 0.75}}))
    with pytest.raises(ConfigError, match=r"settings\.json: keyframes has no setting 'spacing'; valid: spacing_m, "):
        read_config(file)


def test_changed_settings_are_named_as_in_a_file_and_give_the_settings_back():
    config = Config(keyframes=KeyframeConfig(spacing_m=0.75))
    assert changed_settings(Config()) == []
    (text,) = changed_settings(config)
    assert text == "keyframes.spacing_m=0.75"
    place, value = text.split("=")
    stage, name = place.split(".")
    assert settings_of(Config, {stage: {name: float(value)}}) == config
