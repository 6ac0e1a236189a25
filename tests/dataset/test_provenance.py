"""Where a dataset came from, in attributes that NetCDF holds and that lose no bit."""

import json
import re
from importlib.metadata import version

import chaosdrill
from chaosdrill.dataset import label, provenance


def test_parameters_and_settings_keep_every_bit(diagram, system, settings):
    attributes = label(diagram, "bifurcation-diagram", system=system, settings=settings).attrs
    assert json.loads(attributes["parameters"]) == {"e": 0.8, "omega": 1 / 3}
    assert json.loads(attributes["initial"]) == {"mode": "free flight", "x": 0.1}
    assert json.loads(attributes["settings"])["sweep"] == {"e": [0.1, 0.2, 0.3]}
    assert json.loads(attributes["settings"])["steps"] is None


def test_method_and_tolerance_stand_by_themselves(diagram, system, settings):
    attributes = label(diagram, "bifurcation-diagram", system=system, settings=settings).attrs
    assert (attributes["method"], attributes["tolerance"]) == ("taylor", 1e-12)
    assert attributes["kind"] == "bifurcation-diagram"
    assert attributes["system"] == "ball"
    assert attributes["Conventions"] == "CF-1.11, ACDD-1.3"


def test_attributes_are_text_and_numbers(diagram, system, settings):
    attributes = label(diagram, "bifurcation-diagram", system=system, settings=settings).attrs
    assert {type(value) for value in attributes.values()} <= {str, float, int}


def test_history_has_time_version_and_action():
    history = provenance("a title", action="run scene.toml")["history"]
    stamp = r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ"
    assert re.fullmatch(rf"{stamp} chaosdrill {chaosdrill.__version__}: run scene\.toml", history)


def test_versions_of_the_libraries():
    versions = json.loads(provenance("a title", action="run")["versions"])
    assert versions["numpy"] == version("numpy")
    assert versions["chaosdrill"] == chaosdrill.__version__
