"""Other programs open archives of every kind and find the same numbers in them."""

import json
import shutil
import subprocess

import netCDF4
import numpy as np
import pytest

JSFIVE = """
const {File} = require("jsfive");
const bytes = require("fs").readFileSync(process.argv[1]);
const file = new File(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length), "archive");
const found = {};
for (const group of file.keys)
  for (const name of file.get(group).keys) {
    const data = file.get(group).get(name);
    if (data.dtype !== undefined && data.shape !== undefined && data.shape.every((length) => length > 0))
      found[`${group}/${name}`] = Array.from(data.value, String);
  }
console.log(JSON.stringify(found));
"""
"""A reader in JavaScript alone, which shares no line with the HDF5 library."""


def run(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True, timeout=120).stdout


@pytest.fixture(scope="module")
def stored(every_kind):
    """Values of all variables by group/name; empty ones, and mere dimensions, apart."""
    with netCDF4.Dataset(every_kind) as file:
        file.set_auto_mask(False)
        return {
            f"{group}/{name}": variable[...]
            for group, content in file.groups.items()
            for name, variable in content.variables.items()
            if variable.size
        }


@pytest.mark.skipif(not shutil.which("ncdump"), reason="ncdump is not installed (Debian: netcdf-bin)")
def test_ncdump(every_kind, stored):
    text = run("ncdump", "-n", "archive", str(every_kind))
    assert ':Conventions = "CF-1.11, ACDD-1.3"' in text
    value = float(stored["spectrum/kaplan_yorke_dimension"])
    assert f"kaplan_yorke_dimension = {value:g} ;" in text
    for name in stored:
        assert f" {name.split('/')[1]}" in text, name


@pytest.mark.skipif(not shutil.which("ncks"), reason="ncks is not installed (Debian: nco)")
def test_netcdf_operators(every_kind, stored):
    text = run("ncks", "--json", "-g", "section", "-v", "multiplier_real", str(every_kind))
    read = json.loads(text)["groups"]["section"]["variables"]["multiplier_real"]["data"]
    np.testing.assert_allclose(read, stored["section/multiplier_real"], rtol=1e-6)


@pytest.fixture(scope="module")
def node():
    """Node with the package jsfive."""
    if not shutil.which("node"):
        pytest.skip("node is not installed")
    if subprocess.run(["node", "-e", "require('jsfive')"], capture_output=True, check=False).returncode:
        pytest.skip("jsfive is not installed (npm install jsfive, here or where NODE_PATH says)")
    return "node"


def test_javascript(every_kind, stored, node):
    read = json.loads(run(node, "-e", JSFIVE, str(every_kind)))
    # under this name NetCDF-4 keeps a variable that has the name of a dimension and is not its coordinate
    read |= {name.replace("_nc4_non_coord_", ""): values for name, values in read.items() if "_nc4_non_coord_" in name}
    assert stored.keys() - read.keys() == set()
    for name, values in stored.items():
        values = np.asarray(values).ravel()
        if values.dtype.kind in "OU":
            assert read[name] == values.tolist(), name
        else:
            numbers = [float(text.replace("Infinity", "inf")) for text in read[name]]
            np.testing.assert_array_equal(numbers, values.astype(float), err_msg=name)
