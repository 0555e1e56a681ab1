"""info, doctor, --version, completion, configuration."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import trimray
from trimray.cli.options import OPTIONS

from .conftest import Run, process


def test_info_for_the_eye(run: Run, box_file: Path) -> None:
    result = run("info", box_file)
    text = result.out.decode()
    assert result.code == 0 and result.err == ""
    assert "10 x 20 x 30 mm" in text and "plane" in text and "6 drawn, 0 not" in text


def test_info_as_json(run: Run, box_file: Path, ball_file: Path) -> None:
    facts = json.loads(run("info", box_file, "--json").out)
    assert facts["faces"] == 6 and facts["faces_by_kind"] == {"plane": 6} and facts["unit"] == "mm"
    assert facts["bounds_mm"][0] == pytest.approx([-5, -10, -15])
    assert facts["bounds_mm"][1] == pytest.approx([5, 10, 15])
    assert facts["instances"] == 1 and facts["report"]["complete"] is True
    both = json.loads(run("info", box_file, ball_file, "--json").out)
    assert [f["faces_by_kind"] for f in both] == [{"plane": 6}, {"sphere": 1}]


def test_info_json_names_the_bad_file(run: Run, box_file: Path, tmp_path: Path) -> None:
    result = run("info", box_file, tmp_path / "no.step", "--json")
    facts = json.loads(result.out)
    assert result.code == 1 and "no.step" in facts[1]["error"]


def test_version_names_what_it_is_made_of(run: Run) -> None:
    text = run("--version").out.decode()
    assert text.startswith(f"trimray {trimray.__version__}\n")
    for word in ("OpenCascade 7.9", "OpenImageIO 3", "raster backend"):
        assert word in text


def test_doctor(run: Run) -> None:
    result = run("doctor")
    text = result.out.decode()
    assert result.code == 0, text
    for word in ("native core", "OpenCascade: loads", "OpenImageIO: writes png", "cache"):
        assert f"ok    {word}" in text


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion(run: Run, shell: str) -> None:
    assert b"_TRIMRAY_COMPLETE" in run("completion", shell).out


def test_completion_offers_options() -> None:
    words = {"_TRIMRAY_COMPLETE": "bash_complete", "COMP_WORDS": "trimray render --pro", "COMP_CWORD": "2"}
    assert "--progress" in process(**words).out.decode()


def test_help_names_every_option(run: Run) -> None:
    for command in ("render", "info"):
        text = run(command, "--help").out.decode()
        for option in OPTIONS:
            if command in option.commands:
                assert all(flag in text for name in option.flags for flag in name.split("/"))


@pytest.fixture
def config(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    (tmp_path / "trimray").mkdir()
    return tmp_path / "trimray" / "config.toml"


def printed(run: Run, *arguments: str) -> dict[str, object]:
    import tomllib

    return tomllib.loads(run("render", "--print-config", *arguments).out.decode())


def test_flags_beat_environment_beats_file_beats_default(
    run: Run, config: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert printed(run)["samples"] == 4
    config.write_text(
        'samples = 8\nsize = [100, 50]\nview = "top"\ncache = false\naov = ["color", "depth"]\n'
    )
    values = printed(run)
    assert (values["samples"], values["size"], values["view"], values["cache"]) == (8, "100,50", "top", False)
    assert values["aov"] == "color,depth"
    monkeypatch.setenv("TRIMRAY_SAMPLES", "16")
    assert printed(run)["samples"] == 16
    assert printed(run, "--samples", "2")["samples"] == 2
    assert "file" in run("render", "--print-config").out.decode()


def test_what_is_printed_can_be_read_again(run: Run, config: Path) -> None:
    text = run("render", "--print-config", "--view", "10,20", "--size", "64").out.decode()
    config.write_text(text)
    assert printed(run)["view"] == "10,20" and printed(run)["size"] == "64,64"


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("sampels = 3", "did you mean 'samples'"),
        ("samples = ", "config.toml"),
        ("samples = 'many'", "--samples"),
        ("cache = 3", "true or false"),
        ("output = 'a.png'", "unknown option 'output'"),
        ("size = { w = 3 }", "not a value"),
    ],
)
def test_a_wrong_configuration_is_wrong_usage(run: Run, config: Path, text: str, match: str) -> None:
    config.write_text(text)
    result = run("render", "--print-config")
    assert result.code == 2 and match in result.err and result.err.count("\n") == 1


def test_a_wrong_environment_is_wrong_usage(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TRIMRAY_VIEW", "sideways")
    result = run("render", "--print-config")
    assert result.code == 2 and "sideways" in result.err
