"""Image files: what is written is what was given, whole or not at all, and the same bytes each time."""

from __future__ import annotations

import io
import os
import time
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

from trimray import Frame, InputError, OutputError, UsageError
from trimray.image_io import decode, encode, format_of, write_file

W, H = 13, 7


def frame(alpha: bool = False, aovs: bool = False) -> Frame:
    rng = np.random.default_rng(1)
    color = rng.integers(0, 256, (H, W, 4)).astype(np.float32) / 255
    color[..., 3] = np.where(rng.random((H, W)) < 0.5, 0.5, 1.0) if alpha else 1.0
    planes: dict[str, np.ndarray] = {"color": color}
    if aovs:
        planes["depth"] = np.where(rng.random((H, W)) < 0.3, np.inf, 100 * rng.random((H, W)))
        planes["position"] = rng.normal(size=(H, W, 3))
        planes["normal"] = rng.normal(size=(H, W, 3))
        planes["uv"] = rng.normal(size=(H, W, 2))
        planes["face"] = rng.integers(-1, 1 << 24, (H, W)).astype(np.int32)
        planes["instance"] = rng.integers(-1, 9, (H, W)).astype(np.int32)
    return Frame(planes, (W, H))


def read(path: Path) -> tuple[np.ndarray, oiio.ImageSpec]:
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    image = oiio.ImageInput.open(str(path), config)
    spec = image.spec()
    return image.read_image("uint8" if str(spec.format) == "uint8" else "float"), spec


@pytest.mark.parametrize("name", ["a.png", "a.webp", "a.tif", "a.tiff"])
@pytest.mark.parametrize("alpha", [False, True])
def test_lossless_formats_keep_every_byte(tmp_path: Path, name: str, alpha: bool) -> None:
    f = frame(alpha)
    f.save(tmp_path / name)
    pixels, _ = read(tmp_path / name)
    expected = np.floor(f["color"] * 255 + 0.5).astype(np.uint8)
    assert pixels.shape[2] == (4 if alpha else 3)
    assert np.array_equal(pixels, expected[..., : pixels.shape[2]])
    assert os.listdir(tmp_path) == [name]


def test_jpeg_is_near_a_smooth_picture(tmp_path: Path) -> None:
    y, x = np.mgrid[0:32, 0:32] / 31
    color = np.stack([x, y, 0.5 * (x + y), np.ones_like(x)], -1).astype(np.float32)
    Frame({"color": color}, (32, 32)).save(tmp_path / "a.jpg")
    pixels, _ = read(tmp_path / "a.jpg")
    assert np.abs(pixels / 255 - color[..., :3]).max() < 0.03


def test_exr_has_named_channels_and_exact_integers(tmp_path: Path) -> None:
    f = frame(alpha=True, aovs=True)
    f.save(tmp_path / "a.exr")
    pixels, spec = read(tmp_path / "a.exr")
    at = {name: i for i, name in enumerate(spec.channelnames)}
    assert set(at) == {
        *("R", "G", "B", "A", "depth.Z", "position.X", "position.Y", "position.Z"),
        *("normal.X", "normal.Y", "normal.Z", "uv.U", "uv.V", "face.I", "instance.I"),
    }
    assert np.array_equal(pixels[..., at["face.I"]].astype(np.int64), f["face"])
    assert np.array_equal(pixels[..., at["instance.I"]].astype(np.int64), f["instance"])
    assert np.array_equal(pixels[..., at["depth.Z"]], f["depth"].astype(np.float32))
    assert np.array_equal(pixels[..., at["normal.Y"]], f["normal"][..., 1].astype(np.float32))
    # Linear, premultiplied.
    c, a = f["color"][..., 0].astype(float), f["color"][..., 3].astype(float)
    linear = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    assert np.abs(pixels[..., at["R"]] - linear * a).max() < 1e-6
    assert np.abs(pixels[..., at["A"]] - a).max() < 1e-7


@pytest.mark.parametrize("format", ["png", "jpeg", "webp", "tiff", "exr"])
def test_same_bytes_at_another_time(format: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("SOURCE_DATE_EPOCH", raising=False)
    first = encode(frame(), format)
    time.sleep(1.1)  # file dates count in seconds
    assert encode(frame(), format) == first
    assert time.strftime("%Y:%m").encode() not in first


def test_date_comes_from_source_date_epoch_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    frame().save(tmp_path / "a.tif")
    assert read(tmp_path / "a.tif")[1].get_string_attribute("DateTime") == "1970:01:02 00:00:00"


def test_a_stream_takes_any_format() -> None:
    stream = io.BytesIO()
    frame().save(stream)
    assert stream.getvalue().startswith(b"\x89PNG")
    stream = io.BytesIO()
    frame().save(stream, format="tiff")
    assert stream.getvalue()[:2] == b"II"


@pytest.mark.parametrize("name", ["a.avif", "a.heic"])
def test_formats_that_the_wheel_lacks_are_said_to_be_lacking(name: str) -> None:
    with pytest.raises(UsageError, match="lacks"):
        format_of(name)


@pytest.mark.parametrize(
    ("name", "match"), [("a", "no extension"), ("a.pgn", "did you mean 'png'"), ("a.stp", "unknown")]
)
def test_unknown_formats(name: str, match: str) -> None:
    with pytest.raises(UsageError, match=match):
        format_of(name)


@pytest.mark.parametrize("format", ["png", "jpeg", "webp", "tiff"])
def test_pictures_hold_the_colour_alone(format: str) -> None:
    """The other planes of the frame change nothing; without the colour there must be one of them."""
    assert encode(frame(aovs=True), format) == encode(frame(), format)
    depth = {"depth": np.zeros((2, 3))}
    two = Frame(depth | {"uv": np.zeros((2, 3, 2))}, (3, 2))
    with pytest.raises(UsageError, match="one plane only, not depth, uv: write exr"):
        encode(two, format)
    assert encode(two, "exr")[:4] == b"\x76\x2f\x31\x01"
    assert encode(Frame(depth, (3, 2)), format) != encode(Frame({"uv": np.zeros((2, 3, 2))}, (3, 2)), format)


def test_what_does_not_fit_the_format_is_refused() -> None:
    with pytest.raises(UsageError, match="transparency"):
        encode(frame(alpha=True), "jpeg")


def test_output_errors_leave_nothing_behind(tmp_path: Path) -> None:
    for path in (
        tmp_path / "no" / "a.png",
        tmp_path / "folder.png",
        Path("/dev/full"),
        tmp_path / ("n" * 300 + ".png"),
    ):
        if path.name == "folder.png":
            path.mkdir()
        with pytest.raises(OutputError) as caught:
            frame().save(path, format="png")
        assert "\n" not in str(caught.value)
        assert str(path) in str(caught.value)
    assert os.listdir(tmp_path) == ["folder.png"]


def test_a_failing_write_keeps_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "a.png"
    target.write_bytes(b"old")

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(OutputError, match="No space left on device"):
        frame().save(target)
    assert target.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["a.png"]


def test_a_link_is_followed_and_modes_are_the_users(tmp_path: Path) -> None:
    (tmp_path / "link.png").symlink_to(tmp_path / "real.png")
    frame().save(tmp_path / "link.png")
    assert (tmp_path / "link.png").is_symlink()
    umask = os.umask(0)
    os.umask(umask)
    assert (tmp_path / "real.png").stat().st_mode & 0o777 == 0o666 & ~umask


def test_frame_is_a_mapping_of_planes() -> None:
    f = frame(aovs=True)
    assert f.aovs == ("color", "depth", "position", "normal", "uv", "face", "instance")
    assert list(f) == list(f.aovs) and len(f) == 7 and "depth" in f
    with pytest.raises(KeyError, match="ask for it"):
        _ = frame()["depth"]
    with pytest.raises(KeyError):
        _ = f["nothing"]


def test_a_name_may_be_as_long_as_the_file_system_lets_it(tmp_path):
    name = "é" * 125 + ".png"  # 254 bytes
    write_file(str(tmp_path / name), b"1")
    assert [path.name for path in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize("channels", [1, 2, 3, 4])
def test_png_is_read_back_with_straight_alpha(tmp_path: Path, channels: int) -> None:
    pixels = np.random.default_rng(channels).integers(0, 256, (7, 5, channels), np.uint8)
    spec = oiio.ImageSpec(5, 7, channels, "uint8")
    spec.attribute("oiio:UnassociatedAlpha", 1)
    spec.attribute("Source", "a test")
    output = oiio.ImageOutput.create("png")
    assert output.open(str(tmp_path / "a.png"), spec) and output.write_image(pixels) and output.close()
    read, texts = decode((tmp_path / "a.png").read_bytes())
    alpha = pixels[..., -1] if channels in (2, 4) else np.full((7, 5), 255)
    colors = pixels[..., :3] if channels > 2 else np.repeat(pixels[..., :1], 3, axis=-1)
    assert read.dtype == np.uint8 and read.shape == (7, 5, 4)
    assert np.array_equal(read[..., :3], colors) and np.array_equal(read[..., 3], alpha)
    assert texts["Source"] == "a test"


def test_what_is_no_png_is_one_line() -> None:
    sound = encode(Frame({"color": np.ones((4, 4, 4), np.float32)}, (4, 4)), "png")
    huge = sound[:16] + (1 << 30).to_bytes(4, "big") * 2 + sound[24:]
    for data in (b"", b"GIF89a", sound[:20], sound[:-20], huge):
        with pytest.raises(InputError, match=r"^golden\.png: .*PNG") as caught:
            decode(data, "golden.png")
        assert "\n" not in str(caught.value)
