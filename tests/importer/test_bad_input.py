"""Bad input of every kind: one clear line, the right class."""

import gzip
import io
import os
import random
import re
import zipfile

import make
import pytest

from trimray.importer import (
    BrepModel,
    EmptyError,
    InputError,
    MemoryLimitError,
    TimeLimitError,
    UsageError,
    archive,
    read_model,
)
from trimray.importer.formats import sniff
from trimray.importer.step_text import StepText

# Seconds after which a hang of OpenCascade is taken for one.
PATIENCE = 4.0


def test_missing_file(tmp_path):
    with pytest.raises(InputError, match=r"nowhere\.step: No such file or directory$") as caught:
        read_model(tmp_path / "nowhere.step")
    assert caught.value.exit_code == 3 and "\n" not in str(caught.value)


def test_directory(tmp_path):
    with pytest.raises(InputError, match=r"is a directory$"):
        read_model(tmp_path)


def test_empty_file(tmp_path):
    (tmp_path / "a.step").touch()
    with pytest.raises(InputError, match=r"a\.step: empty$"):
        read_model(tmp_path / "a.step")
    with pytest.raises(InputError, match=r"b\.step: empty$"):
        read_model(b"", name="b.step")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_no_permission(tmp_path):
    path = tmp_path / "a.step"
    path.write_text("x")
    path.chmod(0)
    with pytest.raises(InputError, match=r"Permission denied$"):
        read_model(path)


def test_pipe_and_odd_names(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match="not a regular file"):
        read_model(tmp_path / "pipe")
    with pytest.raises(InputError):
        read_model("a\0b.step")


@pytest.mark.parametrize("name", [b"a\xff.step", b"b\xe4/a.step", b"b\xe4/a\xff.brep", b"b\xe4/a.step.gz"])
def test_paths_that_are_no_utf8(tmp_path, name):
    path = os.path.join(os.fsencode(tmp_path), name)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    make_file = make.brep_file if name.endswith(b"brep") else make.step_file
    data = make_file(tmp_path / "plain", make.box()).read_bytes()
    with open(path, "wb") as file:
        file.write(gzip.compress(data) if name.endswith(b".gz") else data)
    assert read_model(os.fsdecode(path)).report["faces"] == 6


def test_foreign_object():
    with pytest.raises(UsageError, match="cannot read a model from int"):
        read_model(3)


@pytest.mark.parametrize(
    "options",
    [
        {"heal": "yes"},
        {"precision": 0.0},
        {"precision": float("nan")},
        {"time_limit": -1},
        {"memory_limit": 0},
    ],
)
def test_wrong_options(options):
    with pytest.raises(UsageError):
        read_model("a.step", **options)


@pytest.mark.parametrize("name", ["noise.step", "noise.igs", "noise.brep", "noise"])
def test_binary_noise(read_here, tmp_path, name):
    path = tmp_path / name
    path.write_bytes(random.Random(1).randbytes(5000))
    with pytest.raises(InputError, match="not a STEP, IGES or BREP file"):
        read_here(path)


@pytest.mark.parametrize("name", ["text.step", "text.igs", "text.brep"])
def test_plain_text_under_a_model_name(read_here, tmp_path, name):
    path = tmp_path / name
    path.write_text("Dear reader,\nthis is no model.\n" * 30)
    with pytest.raises(InputError):
        read_here(path)


def test_step_without_faces(read_here, tmp_path):
    path = tmp_path / "empty.step"
    path.write_text(
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n"
        "FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\nDATA;\n#1=CARTESIAN_POINT('',(0.,0.,0.));\nENDSEC;\n"
        "END-ISO-10303-21;\n"
    )
    with pytest.raises(EmptyError, match="no faces"):
        read_here(path)


def test_self_reference_ends(tmp_path):
    path = make.step_file(tmp_path / "box.step", make.box())
    text, count = re.subn(
        r"(#\d+) = ADVANCED_FACE\('',\(#\d+", r"\1 = ADVANCED_FACE('',(\1", path.read_text(), count=1
    )
    assert count == 1
    path.write_text(text)
    try:
        report = read_model(path, time_limit=PATIENCE).report
    except (InputError, TimeLimitError) as error:
        assert "box.step" in str(error)
    else:
        assert report["issues"]


@pytest.mark.parametrize("replacement", ["NaN", "1.E+300", "-1.E+308"])
def test_wild_coordinates_end_in_a_model_or_an_input_error(tmp_path, replacement):
    path = make.step_file(tmp_path / "box.step", make.box())
    path.write_text(path.read_text().replace("(10.,", f"({replacement},", 3))
    try:
        assert isinstance(read_model(path, time_limit=PATIENCE), BrepModel)
    except (InputError, TimeLimitError) as error:
        assert "\n" not in str(error)


@pytest.mark.parametrize(
    ("name", "wrap"),
    [("a.step.gz", gzip.compress), ("a.stpZ", gzip.compress), ("a.stp.zip", None), ("a.stpZ", None)],
)
def test_compressed_files_are_found_by_their_magic(read_here, tmp_path, name, wrap):
    plain = make.step_file(tmp_path / "plain.step", make.box()).read_bytes()
    path = tmp_path / name
    if wrap is not None:
        path.write_bytes(wrap(plain))
    else:
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
            file.writestr("readme.txt", "hello")
            file.writestr("folder/../a.stp", plain)
    model = read_here(path)
    assert model.report["faces"] == 6
    assert model.source["archive"] in ("gzip", "zip")


def test_damaged_archives(read_here, tmp_path):
    plain = make.step_file(tmp_path / "plain.step", make.box()).read_bytes()
    squeezed = gzip.compress(plain)
    for name, data in {
        "cut.step.gz": squeezed[: len(squeezed) // 2],
        "bad.step.gz": squeezed[:40] + b"\xff" * 60 + squeezed[100:],
        "cut.stp.zip": b"PK\x03\x04" + b"\0" * 50,
    }.items():
        (tmp_path / name).write_bytes(data)
        with pytest.raises(InputError, match="archive"):
            read_here(tmp_path / name)
    with zipfile.ZipFile(tmp_path / "none.zip", "w") as file:
        file.writestr("readme.txt", "hello")
    with pytest.raises(InputError, match="no STEP, IGES or BREP file in the archive"):
        read_here(tmp_path / "none.zip")


@pytest.mark.parametrize("kind", ["gzip", "zip"])
def test_bomb_is_stopped_at_the_limit(tmp_path, kind):
    data = b"ISO-10303-21;\n" + b" " * (40 << 20)
    path = tmp_path / "bomb"
    if kind == "gzip":
        path.write_bytes(gzip.compress(data))
    else:
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
            file.writestr("a.stp", data)
    folder = tmp_path / "out"
    folder.mkdir()
    with pytest.raises(MemoryLimitError, match="unpacks to more than 8 MiB"):
        archive.unpack(path, kind, folder, name="bomb", memory_limit=8 << 20)
    assert sum(f.stat().st_size for f in folder.iterdir()) <= 9 << 20


def test_bytes_and_open_files_are_read(tmp_path):
    data = make.step_file(tmp_path / "box.step", make.box()).read_bytes()
    assert read_model(data, name="-").report["faces"] == 6
    assert read_model(io.BytesIO(data), name="stdin").source["name"] == "stdin"


def test_content_decides_before_the_extension(read_here, tmp_path):
    step = make.step_file(tmp_path / "a.step", make.box()).rename(tmp_path / "a.igs")
    assert read_here(step).report["format"] == "step"
    iges = make.iges_file(tmp_path / "b.igs", make.box()).rename(tmp_path / "b.txt")
    assert read_here(iges).report["format"] == "iges"


def test_sniffing():
    assert sniff(b"\xef\xbb\xbfISO-10303-21;") == "step"
    assert sniff(b"/* note */\nISO-10303-21;\nHEADER;") == "step"
    assert sniff(b" " * 72 + b"S      1\n") == "iges"
    assert sniff(b" " * 72 + b"S0000001\r\n") == "iges"
    assert sniff(b"hello", "a.txt") == "unknown"
    assert sniff(b"\0\1\2\3", "a.step") == "unknown"
    assert sniff(b"") == "unknown"


def test_a_coordinate_that_is_no_number_is_named_when_opencascade_does_not_end_on_it(tmp_path, monkeypatch):
    monkeypatch.setattr("trimray.importer.step_document._PATIENCE_WITH_NAN", 1)  # second
    path = make.step_file(tmp_path / "box.step", make.box())
    path.write_text(path.read_text().replace("(10.,", "(NaN,", 3))
    with pytest.raises(InputError, match=r"#\d+ \(CARTESIAN_POINT\) holds a coordinate that is not a number"):
        read_model(path, start="fork")  # no limit of ours: the reading process sets its own alarm


@pytest.mark.parametrize(
    ("record", "found"),
    [
        (b"#7=CARTESIAN_POINT('',(0.,NaN,1.));", 7),
        (b"#8 = DIRECTION('nan',(-inf,0.,1.));", 8),
        (b"#9=CARTESIAN_POINT('a,nan,b',(0.,1.,2.));", None),
        (b"#10=PRODUCT('nan','nancy','',(#1));", None),
        (b"#11=CARTESIAN_POINT('',(0.,Infinity,1.));", 11),
    ],
)
def test_numbers_that_are_none_are_told_from_words(record, found):
    text = StepText(b"ISO-10303-21;DATA;#1=X('');" + record + b"ENDSEC;END-ISO-10303-21;")
    defect = text.not_a_number()
    assert (defect.id if defect else None) == found


def test_a_name_that_is_no_utf8_leaves_text_that_is(tmp_path):
    path = os.path.join(os.fsencode(tmp_path), b"a\xff.step")
    os.rename(make.step_file(tmp_path / "a.step", make.box()), path)
    meta = read_model(os.fsdecode(path)).meta_json()
    assert "a\ufffd" in meta and meta.encode()
