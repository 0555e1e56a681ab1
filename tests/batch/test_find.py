"""Every model once, whatever the folders look like; every picture in a place of its own."""

from __future__ import annotations

import os
import unicodedata
from pathlib import Path

import pytest

from trimray import UsageError
from trimray.batch.find import File, Found, find
from trimray.batch.targets import Template, format_of_template, targets


def write(path: Path, size: int = 10) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(b"x" * size)
    return path


def names(found: Found) -> list[str]:
    return [file.relative for file in found.files]


def test_models_are_told_by_their_extensions_in_any_case(tmp_path: Path) -> None:
    taken = ["a.step", "b.STP", "c.p21", "d.stpZ", "e.step.gz", "f.IGES.zip", "g.igs", "h.brep", "i.stl"]
    taken += ["j.Obj", "k.ply", "l.off", "m.brp", "n.iges"]
    for name in [*taken, "a.png", "b.txt", "c.zip", "d.gz", "step", "e.step~", "f.step.bak"]:
        write(tmp_path / name)
    assert sorted(names(find([str(tmp_path)]))) == sorted(taken)


def test_the_largest_comes_first_and_ties_go_by_path(tmp_path: Path) -> None:
    for name, size in (("a/s.step", 10), ("b/l.step", 30), ("c.step", 20), ("a/r.step", 10)):
        write(tmp_path / name, size)
    found = find([str(tmp_path)])
    assert names(found) == ["b/l.step", "c.step", "a/r.step", "a/s.step"]
    assert [file.size for file in found.files] == [30, 20, 10, 10]
    assert all(file.mtime_ns > 0 and os.path.isabs(file.path) for file in found.files)


def test_globs_replace_the_extensions(tmp_path: Path) -> None:
    for name in ("a.step", "sub/b.step", "sub/c.dat", "sub/deep/d.DAT"):
        write(tmp_path / name)
    top = str(tmp_path)
    assert sorted(names(find([top], include=["*.dat"]))) == ["sub/c.dat", "sub/deep/d.DAT"]
    assert sorted(names(find([top], include=["sub/*.step", "a.*"]))) == ["a.step", "sub/b.step"]
    with pytest.raises(UsageError, match="empty pattern"):
        find([top], include=[""])


def test_a_file_that_is_named_is_taken_whatever_it_is(tmp_path: Path) -> None:
    odd = write(tmp_path / ".hidden.dat")
    found = find([str(odd), str(tmp_path / "missing.step")])
    assert sorted(names(found)) == [".hidden.dat", "missing.step"]
    with pytest.raises(UsageError, match="empty path"):
        find([""])
    with pytest.raises(UsageError, match="NUL"):
        find(["a\0b"])


def test_hidden_names_in_folders_are_left_out(tmp_path: Path) -> None:
    for name in ("a.step", ".b.step", ".git/c.step", "d/.e/f.step"):
        write(tmp_path / name)
    assert names(find([str(tmp_path)])) == ["a.step"]
    assert names(find([str(tmp_path / ".git")])) == ["c.step"]


def test_loops_of_links_end_and_each_folder_is_searched_once(tmp_path: Path) -> None:
    write(tmp_path / "z/part.step")
    (tmp_path / "z/up").symlink_to("..")
    (tmp_path / "z/self").symlink_to(".")
    (tmp_path / "a").symlink_to("z")  # sorts before what it leads to, which yet comes first
    found = find([str(tmp_path)])
    assert names(found) == ["z/part.step"] and found.failures == []


def test_links_to_folders_elsewhere_are_followed(tmp_path: Path) -> None:
    write(tmp_path / "else/part.step")
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib/link").symlink_to("../else")
    assert names(find([str(tmp_path / "lib")])) == ["link/part.step"]


def test_broken_links_are_items_and_so_are_links_to_themselves(tmp_path: Path) -> None:
    (tmp_path / "gone.step").symlink_to("nowhere")
    (tmp_path / "self.step").symlink_to("self.step")
    (tmp_path / "gone").symlink_to("nowhere")
    found = find([str(tmp_path)])
    assert names(found) == ["gone.step", "self.step"]
    assert {(file.size, file.mtime_ns) for file in found.files} == {(0, 0)}


def test_a_pipe_is_an_item_and_is_not_opened(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.step")
    assert find([str(tmp_path)]).files == [File(str(tmp_path / "pipe.step"), "")]


def test_overlapping_paths_give_each_file_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    part = write(tmp_path / "lib/sub/part.step")
    write(tmp_path / "lib/other.step")
    monkeypatch.chdir(tmp_path)
    for paths in (
        ["lib", "lib/sub", str(part)],
        [str(part), "lib", "./lib/"],
        ["lib/sub", "lib/../lib", "lib/sub/part.step", "lib/sub/part.step"],
    ):
        assert sorted(file.path for file in find(paths).files) == [
            str(tmp_path / "lib/other.step"),
            str(part),
        ]
    assert names(find(["lib/sub", "lib"])) == ["other.step", "part.step"]


def test_folders_that_cannot_be_searched_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Permissions do not hold root back, so the system's answer is made up."""
    write(tmp_path / "a.step")
    write(tmp_path / "locked/b.step")
    scandir = os.scandir

    def refuse(path: str) -> object:
        if str(path).endswith("locked"):
            raise PermissionError(13, "Permission denied")
        return scandir(path)

    monkeypatch.setattr(os, "scandir", refuse)
    found = find([str(tmp_path)])
    assert names(found) == ["a.step"]
    [failure] = found.failures
    assert failure.path == str(tmp_path / "locked") and failure.exit_code == 3
    assert "Permission denied" in failure.reason


def test_a_tree_deeper_than_paths_can_be_is_named(tmp_path: Path) -> None:
    write(tmp_path / "a.step")
    here = os.getcwd()
    os.chdir(tmp_path)
    try:
        for _ in range(30):
            os.mkdir("d" * 200)
            os.chdir("d" * 200)
        Path("deep.step").write_bytes(b"x")
        found = find([str(tmp_path)])
    finally:
        os.chdir(here)
    assert names(found) == ["a.step"]
    assert "name too long" in found.failures[0].reason


def test_the_folder_of_the_pictures_is_not_searched(tmp_path: Path) -> None:
    write(tmp_path / "a.step")
    out = write(tmp_path / "out/b.step").parent
    assert names(find([str(tmp_path)], leave_out=str(out))) == ["a.step"]
    assert names(find([str(out)], leave_out=str(out))) == ["b.step"]


def test_names_of_any_bytes_are_found(tmp_path: Path) -> None:
    for raw in (
        b"caf\xe9.step",
        b"new\nline.step",
        b"q\"uote's.step",
        b" sp ace .step",
        "日本.step".encode(),
    ):
        with open(os.path.join(os.fsencode(tmp_path), raw), "wb") as file:
            file.write(b"x")
    found = {os.fsencode(file.name) for file in find([str(tmp_path)]).files}
    assert b"caf\xe9.step" in found and b"new\nline.step" in found and len(found) == 5


def of(*paths: str) -> list[File]:
    return [File(f"/lib/{path}", path.rpartition("/")[0]) for path in paths]


def aims(*paths: str, template: str | None = None) -> list[str]:
    return targets(of(*paths), Template(template, "png"))


def test_pictures_keep_the_folders_and_names_of_their_files() -> None:
    assert aims("a/b/part.step", "x.step.gz", "y") == ["a/b/part.png", "x.png", "y.png"]
    assert aims("a/b.STEP", template="{ext}/{name}_{parent}.{format}") == ["STEP/b_a.png"]
    assert aims("a/b.stp", template="flat/{name}.webp") == ["flat/b.webp"]
    assert targets(of("a.step"), Template(None, "jpeg")) == ["a.jpg"]


def test_files_that_would_share_a_picture_get_their_full_names() -> None:
    assert aims("part.step", "part.iges", "other.step") == ["part.step.png", "part.iges.png", "other.png"]
    # A third one that has such a name already does not get lost either.
    three = aims("part.step", "part.iges", "part.step.stl")
    assert len(set(three)) == 3 and three[1] == "part.iges.png"


def test_where_names_do_not_help_a_mark_of_the_path_does() -> None:
    files = [File("/x/part.step", ""), File("/y/part.step", "")]
    first, second = targets(files, Template(None, "png"))
    assert first != second and first.startswith("part.step~") and second.endswith(".png")
    assert targets(files[::-1], Template(None, "png")) == [second, first]
    many = aims(*(f"{k}/a.step" for k in range(50)), template="same.png")
    assert len(set(many)) == 50 and all(name.startswith("same~") for name in many)


def test_names_that_differ_in_case_alone_do_not_share_a_picture() -> None:
    """Some file systems take them for one, or names whose accents are composed otherwise."""
    upper, lower, other = aims("Part.step", "part.step", "peg.step")
    assert upper.startswith("Part.step~") and lower.startswith("part.step~") and other == "peg.png"
    assert upper.casefold() != lower.casefold()
    assert aims("Part.step", "part.iges") == ["Part.step.png", "part.iges.png"]
    composed, apart = aims("caf\u00e9.step", "cafe\u0301.step")
    assert len({unicodedata.normalize("NFC", name) for name in (composed, apart)}) == 2
    strasse, street = aims("STRASSE.step", "stra\u00dfe.step")
    assert strasse.casefold() != street.casefold()
    assert aims("A/a.step", "a/b.step") == ["A/a.png", "a/b.png"]  # one folder, then
    assert aims("x.step", "X.PNG/a.step")[0] == "x.step.png"
    assert aims("Index.step", template="{name}.HTML") != ["Index.HTML"]
    assert aims("\udcff.step", "\udcfe.step") == ["\udcff.png", "\udcfe.png"]


def test_a_picture_is_no_folder_of_others_and_no_file_of_the_batch() -> None:
    file, below = aims("a.step", "a.png/b.step")
    assert below == "a.png/b.png" and file == "a.step.png"
    reserved = aims("index.step", "trimray-batch.sqlite.step", template="{name}.html")
    assert "index.html" not in reserved
    assert aims("trimray-batch.step", template="{name}.sqlite") != ["trimray-batch.sqlite"]


def test_names_that_are_too_long_are_cut_and_stay_apart() -> None:
    long = "é" * 126  # 252 bytes, + ".stp" would fit but not with another extension
    made = aims(f"{long}a.x.stp", f"{long}b.x.stp", "k" * 300 + "/c.stp")
    assert len(set(made)) == 3
    for target in made:
        assert all(len(os.fsencode(part)) <= 255 for part in target.split("/"))
        assert target.endswith(".png")
        target.encode()  # no character was cut in two


@pytest.mark.parametrize(
    ("template", "message"),
    [
        ("{nam}.png", "unknown field '{nam}', did you mean 'name'"),
        ("{}.png", "unknown field"),
        ("{0}.png", "unknown field"),
        ("{name.__class__}.png", "unknown field"),
        ("{name[0]}.png", "unknown field"),
        ("{name!r}.png", "takes nothing"),
        ("{name:>10}.png", "takes nothing"),
        ("{name", "expected '}'"),
        ("/tmp/{name}.png", "leaves the folder"),
        ("../{name}.png", "leaves the folder"),
        ("{parent}/../../{name}.png", "leaves the folder"),
        ("", "names no file"),
        ("{name}/", "names no file"),
        ("{name}\0.png", "names no file"),
    ],
)
def test_wrong_templates_are_refused(template: str, message: str) -> None:
    with pytest.raises(UsageError) as error:
        Template(template, "png")
    assert message in str(error.value)


def test_no_picture_leaves_the_folder() -> None:
    made = aims("a/...step", "b/..step", ".step", template="{parent}/{name}")
    assert all(".." not in target.split("/") and not target.startswith("/") and target for target in made)


def test_the_format_is_the_templates_unless_one_is_asked_for() -> None:
    assert format_of_template(None, None) == "png"
    assert format_of_template("{name}.jpg", None) == "jpeg"
    assert format_of_template("{name}.jpg", "webp") == "webp"
    assert format_of_template("{name}", "jpg") == "jpeg"
    with pytest.raises(UsageError, match="unknown picture format"):
        format_of_template(None, "pgn")
