"""What is said of the sources: their own commit, or none."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from tactgen.validation.engine import origin

NONE = "installed without its repository"
pytestmark = pytest.mark.skipif(shutil.which("git") is None, reason="no git on this machine")


@pytest.fixture
def repository(tmp_path, monkeypatch):
    """Return what runs git in a repository with one commit, in which the sources seem to stand."""
    for variable in ("GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE"):  # a hook's
        monkeypatch.delenv(variable, raising=False)
    who = ("-c", "user.name=a", "-c", "user.email=a@example.org", "-c", "commit.gpgSign=false")
    sources = tmp_path / "sources.py"
    sources.write_text("", encoding="utf-8")
    monkeypatch.setattr(origin, "__file__", str(sources))

    def git(*asked):
        subprocess.run(["git", "-C", str(tmp_path), *who, *asked], check=True, capture_output=True)

    git("init")
    git("commit", "--allow-empty", "--no-verify", "-m", "theirs")
    return git


def test_the_commit_of_the_sources(repository):
    """Twelve digits in every clone; tags change nothing, changes that are not committed do."""
    repository("add", "sources.py")
    repository("commit", "--no-verify", "-m", "ours")
    repository("tag", "-m", "a tag", "v1")
    clean = origin._commit()
    assert re.fullmatch("[0-9a-f]{12}", clean)
    Path(origin.__file__).write_text("changed", encoding="utf-8")
    assert origin._commit() == f"{clean}-dirty"


def test_another_projects_commit_is_not_ours(repository):
    """In an environment inside of somebody's checkout the sources are of no commit."""
    assert origin._commit() == NONE
