"""The entry for the registry of MDAKits: what it must have, and that it agrees with the package."""

import tomllib
from pathlib import Path

import pytest

import loopelastica as le

ROOT = Path(__file__).resolve().parents[1]
# those that the registry refuses an entry without, and what it is written as
REQUIRED = {
    "project_name": str,
    "authors": list,
    "maintainers": list,
    "description": str,
    "keywords": list,
    "license": str,
    "project_home": str,
    "documentation_home": str,
    "documentation_type": str,
}
# the others that it knows
OPTIONAL = {
    "install": list,
    "src_install": list,
    "import_name": str,
    "python_requires": str,
    "mdanalysis_requires": str,
    "run_tests": list,
    "test_dependencies": list,
    "project_org": str,
    "development_status": str,
    "publications": list,
    "community_home": str,
    "changelog": str,
}


@pytest.fixture
def text():
    return (ROOT / ".mdakit" / "metadata.yaml").read_text("utf-8")


@pytest.fixture
def metadata(text):
    return pytest.importorskip("yaml").safe_load(text)


@pytest.fixture
def project():
    return tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]


@pytest.mark.parametrize("name", REQUIRED)
def test_no_required_field_is_missing_or_empty(metadata, name):
    assert isinstance(metadata[name], REQUIRED[name])
    assert metadata[name]


def test_every_other_field_is_one_that_the_registry_has(metadata):
    others = {name: value for name, value in metadata.items() if name not in REQUIRED}
    assert set(others) <= set(OPTIONAL)
    assert all(isinstance(value, OPTIONAL[name]) for name, value in others.items())
    lists = [value for value in metadata.values() if isinstance(value, list)]
    assert all(isinstance(entry, str) for value in lists for entry in value)


def test_the_entry_says_of_versions_and_licence_what_the_package_says(metadata, project):
    assert metadata["project_name"] == metadata["import_name"] == project["name"]
    assert metadata["license"] == project["license"]
    assert metadata["python_requires"] == project["requires-python"]
    (needed,) = [one for one in project["dependencies"] if one.startswith("MDAnalysis")]
    assert needed == f"MDAnalysis{metadata['mdanalysis_requires']}"
    status = f"- {metadata['development_status']}"
    assert any(one.endswith(status) for one in project["classifiers"])


def test_the_tests_run_from_a_checkout_with_what_the_installation_brings(metadata, project):
    assert metadata["run_tests"] == ["git clone latest", "pytest tests"]
    assert all("[dev]" in one for one in (*metadata["install"], *metadata["src_install"]))
    assert any(one.startswith("pytest") for one in project["optional-dependencies"]["dev"])


def test_whatever_the_owner_has_to_fill_in_is_marked(text):
    lines = [line for line in text.splitlines() if not line.lstrip().startswith("#")]
    for line in lines:
        assert ("OWNER" in line) == ("# fill in" in line)


def test_the_citation_is_of_this_version(project):
    citation = pytest.importorskip("yaml").safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    assert citation["version"] == le.__version__
    assert citation["license"] == project["license"]
