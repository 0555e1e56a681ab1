"""Registration: what is written is in force, what is taken back is all of it and nothing else."""

from __future__ import annotations

import configparser
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from trimray import OutputError
from trimray.desktop import install, mime, sealed
from trimray.desktop.install import Place

needs_tool = pytest.mark.skipif(
    shutil.which("update-mime-database") is None, reason="no update-mime-database (shared-mime-info)"
)


def tree(folder: Path) -> dict[str, bytes | None]:
    """Relative path to content; None for a folder."""
    return {
        str(path.relative_to(folder)): None if path.is_dir() else path.read_bytes()
        for path in folder.rglob("*")
    }


class Steps(list[str]):
    def __call__(self, verb: str, what: str) -> None:
        self.append(f"{verb} {what}")


@pytest.fixture
def place(tmp_path: Path) -> Place:
    """Alone in the world: no types and thumbnailers of others."""
    data = tmp_path / "data"
    data.mkdir()
    return Place(str(data), (str(data),))


def entry_of(place: Place) -> configparser.SectionProxy:
    parser = configparser.RawConfigParser()
    parser.optionxform = str  # type: ignore[assignment,method-assign]
    parser.read(place.entry, encoding="utf-8")
    return parser["Thumbnailer Entry"]


def add_package(folder: Path, content: str, name: str = "other.xml") -> None:
    packages = folder / "mime" / "packages"
    packages.mkdir(parents=True, exist_ok=True)
    head = '<mime-info xmlns="http://www.freedesktop.org/standards/shared-mime-info">'
    (packages / name).write_text(f"<?xml version='1.0'?>{head}{content}</mime-info>")


def add_thumbnailer(folder: Path, types: str) -> Path:
    path = folder / "thumbnailers" / "other.thumbnailer"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"[Thumbnailer Entry]\nExec=other %i %o\nMimeType={types}\n")
    return path


@needs_tool
def test_uninstall_leaves_what_was_there_before_install(place: Place) -> None:
    data = Path(place.data)
    assert install.install(place, "/opt/bin/trimray-thumbnailer", Steps()) == []
    assert (data / "mime" / "globs2").exists() and os.path.exists(place.entry)
    assert install.uninstall(place, Steps()) == []
    assert tree(data) == {}


@needs_tool
def test_what_is_not_ours_survives(place: Place) -> None:
    data = Path(place.data)
    add_package(data, '<mime-type type="a/b"><glob pattern="*.ab"/></mime-type>')
    add_thumbnailer(data, "a/b;")
    (data / "other").write_text("untouched")
    subprocess.run(["update-mime-database", data / "mime"], check=True)
    before = tree(data)
    install.install(place, "/opt/bin/trimray-thumbnailer", Steps())
    assert "*.step" in (data / "mime" / "globs2").read_text()
    install.uninstall(place, Steps())
    after = tree(data)
    assert after.keys() == before.keys()
    assert {k for k in before if before[k] != after[k]} <= {"mime/mime.cache", "mime/version"}


def test_twice_is_once(place: Place) -> None:
    install.install(place, "/opt/bin/trimray-thumbnailer", Steps())
    before, steps = tree(Path(place.data)), Steps()
    install.install(place, "/opt/bin/trimray-thumbnailer", steps)
    assert steps == [] and tree(Path(place.data)) == before
    install.install(place, "/usr/lib/elsewhere/trimray-thumbnailer", steps)
    assert steps == [f"write {place.entry}"]
    install.uninstall(place, Steps())
    assert tree(Path(place.data)) == {}
    assert install.uninstall(place, steps) == [] and len(steps) == 1


def test_a_dry_run_writes_nothing(place: Place) -> None:
    steps = Steps()
    install.install(place, "/opt/bin/trimray-thumbnailer", steps, dry_run=True)
    assert {f"write {place.package}", f"write {place.entry}"} <= set(steps)
    assert tree(Path(place.data)) == {}
    install.install(place, "/opt/bin/trimray-thumbnailer", Steps())
    before, steps = tree(Path(place.data)), Steps()
    install.uninstall(place, steps, dry_run=True)
    assert {f"remove {place.package}", f"remove {place.entry}"} <= set(steps)
    assert tree(Path(place.data)) == before


@pytest.mark.parametrize("which", ["entry", "package"])
def test_a_changed_file_is_left_and_named(place: Place, which: str) -> None:
    install.install(place, "/opt/bin/trimray-thumbnailer", Steps())
    path = Path(getattr(place, which))
    path.write_text(path.read_text().replace("model/step", "model/mine"))
    changed = path.read_bytes()
    with pytest.raises(OutputError, match="not as we wrote it"):
        install.install(place, "/elsewhere/trimray-thumbnailer", Steps())
    remarks = install.uninstall(place, Steps())
    assert len(remarks) == 1 and remarks[0].startswith(f"!{path}")
    assert path.read_bytes() == changed
    other = place.package if which == "entry" else place.entry
    assert not os.path.exists(other)


def test_a_folder_that_cannot_be_written(place: Place) -> None:
    Path(place.data, "thumbnailers").write_text("in the way")
    with pytest.raises(OutputError, match="not written"):
        install.install(place, "/opt/bin/trimray-thumbnailer", Steps())


def test_without_the_tool_one_line_says_so(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "/nowhere")
    remarks = install.install(place, "/opt/bin/trimray-thumbnailer", Steps())
    assert len(remarks) == 1 and remarks[0].startswith("!update-mime-database is not there")
    assert len(install.uninstall(place, Steps())) == 1
    assert tree(Path(place.data)) == {}


@pytest.mark.parametrize(
    "program",
    ["/opt/bin/trimray-thumbnailer", "/opt/a b/$x`\"'\\%s;\u00e9/trimray-thumbnailer", "/a=b/[c]#/t"],
)
def test_the_command_survives_the_desktop(place: Place, program: str) -> None:
    """As GLib reads an entry: value of a key file, words of a shell, then its own %."""
    install.install(place, program, Steps())
    entry = entry_of(place)
    assert entry["TryExec"].replace("\\\\", "\\") == program
    line = entry["Exec"].replace("\\\\", "\\")
    script = f"printf '%s\\n' {line}"
    words = subprocess.run(["sh", "-c", script], capture_output=True, text=True, check=True).stdout.split(
        "\n"
    )
    assert [word.replace("%%", "%") for word in words[:1]] == [program]
    assert words[1:] == ["-s", "%s", "%i", "%o", ""]


def test_a_path_that_no_entry_can_hold(place: Place) -> None:
    for program in ("/a\nb/t", "/\udcff/t"):
        with pytest.raises(OutputError, match="printable"):
            install.install(place, program, Steps())
    assert tree(Path(place.data, "thumbnailers")) == {}


def test_types_of_others_stay_theirs(place: Place) -> None:
    add_package(
        Path(place.data),
        '<mime-type type="model/iges"><glob pattern="*.igs"/><alias type="application/iges"/></mime-type>'
        '<mime-type type="application/x-shape"><glob pattern="*.BREP"/></mime-type>'
        '<mime-type type="application/step"><magic><match type="string" value="x" offset="0"/></magic>'
        "</mime-type>",
    )
    known = mime.known_types([place.data], install.PACKAGE)
    missing = {each.name: each for each in mime.missing_types(known)}
    assert missing["model/iges"].globs == () and missing["model/iges"].comment == ""
    assert missing["model/iges"].aliases == ("application/x-iges", "model/x-iges")
    assert missing["model/x-brep"].globs == ("*.brp",)
    assert "application/step" not in missing["model/step"].aliases
    assert missing["model/step"].globs == ("*.step", "*.stp", "*.p21")


def test_a_broken_package_is_none(place: Place) -> None:
    packages = Path(place.data, "mime", "packages")
    packages.mkdir(parents=True)
    (packages / "broken.xml").write_text("<mime-info")
    (packages / "folder.xml").mkdir()
    assert mime.missing_types(mime.known_types([place.data, "/nowhere"], "x")) == list(mime.TYPES)


def test_triangles_are_left_to_those_who_draw_them(place: Place) -> None:
    data = Path(place.data)
    add_package(
        data,
        '<mime-type type="model/stl"><glob pattern="*.stl"/></mime-type>'
        '<mime-type type="model/obj"><glob pattern="*.obj"/></mime-type>',
    )
    other = add_thumbnailer(data, "model/stl;model/step;")
    remarks = install.install(place, "/opt/bin/trimray-thumbnailer", Steps())
    types = entry_of(place)["MimeType"].split(";")
    assert "model/obj" in types and "model/stl" not in types and "model/step" in types
    assert any("model/stl" in remark and str(other) in remark for remark in remarks)
    assert any(remark.startswith(f"{other} claims") for remark in remarks)


def test_places() -> None:
    assert install.user_place({"HOME": "/h"}).data == "/h/.local/share"
    assert install.user_place({"HOME": "/h", "XDG_DATA_HOME": "relative"}).data == "/h/.local/share"
    assert install.user_place({"XDG_DATA_HOME": "/d", "XDG_DATA_DIRS": "/x:y:/z/"}).others == (
        "/d",
        "/x",
        "/z",
    )
    with pytest.raises(OutputError):
        install.user_place({})
    assert install.system_place({}).data == "/usr/local/share"
    assert install.system_place({"XDG_DATA_DIRS": "/usr/share:/usr/local/share/"}).data == "/usr/local/share"
    assert install.system_place({"XDG_DATA_DIRS": "/opt/share"}).data == "/opt/share"


def test_what_lies_outside_of_the_sandbox(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(install, "__file__", "/usr/local/lib/trimray/lib/trimray/desktop/install.py")
    monkeypatch.setattr(sys, "prefix", "/usr/local/lib/trimray")
    monkeypatch.setattr(sys, "base_prefix", "/usr")
    inside = "/usr/local/lib/trimray/bin/trimray-thumbnailer"
    assert install.outside_of_sandbox(inside) == []
    assert install.outside_of_sandbox("/opt/bin/x") == ["/opt/bin/x"]
    monkeypatch.setattr(sys, "base_prefix", "/home/me/python")
    assert install.outside_of_sandbox(inside) == ["/home/me/python"]


def test_a_seal_breaks_at_any_change() -> None:
    for xml in (False, True):
        data = sealed.seal("a\nb\n", xml=xml).encode()
        assert sealed.opened(data) == "a\nb\n"
        for at in range(len(data)):
            assert sealed.opened(data[:at] + bytes([data[at] ^ 1]) + data[at + 1 :]) is None
            assert sealed.opened(data[:at]) is None
        assert sealed.opened(data + b"x") is None and sealed.opened(b"\xff" + data) is None


@needs_tool
@pytest.mark.skipif(shutil.which("gio") is None, reason="no gio (libglib2.0-bin)")
@pytest.mark.parametrize("alone", [True, False])
def test_the_desktop_knows_the_types(tmp_path: Path, samples_dir: Path, alone: bool) -> None:
    """By name in any case, and by content. alone: no other packages are there."""
    data = tmp_path / "data"
    others = "/nowhere" if alone else "/usr/local/share:/usr/share"
    environment = {"XDG_DATA_HOME": str(data), "XDG_DATA_DIRS": others}
    install.install(install.user_place(environment), "/opt/bin/trimray-thumbnailer", Steps())
    named = {
        "a.step": "model/step",
        "a.STP": "model/step",
        "a.p21": "model/step",
        "a.stpZ": "model/step+zip",
        "a.igs": "model/iges",
        "a.IGES": "model/iges",
        "a.brep": "model/x-brep",
        "a.Brp": "model/x-brep",
    }
    for name in named:
        (tmp_path / name).write_bytes(b"\1\2 nothing that tells")
    for sample, kind in (("bracket.step", "model/step"), ("bracket.brep", "model/x-brep")):
        shutil.copy(samples_dir / sample, tmp_path / f"{sample[8:]}-without-extension")
        named[f"{sample[8:]}-without-extension"] = kind
    command = ["gio", "info", "-a", "standard::content-type", *named]
    done = subprocess.run(
        command, capture_output=True, text=True, cwd=tmp_path, env=os.environ | environment, check=True
    )
    found = [line.split(": ")[1] for line in done.stdout.splitlines() if "standard::content-type:" in line]
    assert dict(zip(named, found, strict=True)) == named
