"""URIs are GLib's, byte by byte, for the name of a thumbnail is the MD5 of one."""

from __future__ import annotations

import ctypes
import ctypes.util
import hashlib
import os
import random
from pathlib import Path

import pytest

from trimray.desktop.uris import file_uri, path_of


def test_the_example_of_the_standard() -> None:
    uri = file_uri("/home/jens/photos/me.png")
    assert uri == "file:///home/jens/photos/me.png"
    assert hashlib.md5(uri.encode()).hexdigest() == "c6ee772d9e49320e97ec29a7eb5b1697"


def test_every_byte_is_escaped_as_glib_does_it() -> None:
    name = ctypes.util.find_library("glib-2.0")
    if name is None:
        pytest.skip("no GLib on this machine")
    glib = ctypes.CDLL(name)
    glib.g_filename_to_uri.restype = ctypes.c_void_p
    glib.g_filename_to_uri.argtypes = [ctypes.c_char_p, ctypes.c_void_p, ctypes.c_void_p]

    def of_glib(path: bytes) -> str:
        pointer = glib.g_filename_to_uri(path, None, None)
        assert pointer
        return ctypes.string_at(pointer).decode()

    random_bytes = random.Random(1)
    paths = [b"/a" + bytes([byte]) + b"b" for byte in range(1, 256) if byte != ord("/")]
    paths += [b"/" + bytes(random_bytes.choice(range(1, 256)) for _ in range(40)) for _ in range(200)]
    checked = 0
    for path in paths:
        text = os.fsdecode(path)
        if os.path.abspath(text) == text:  # what is normalized is another path
            assert file_uri(text) == of_glib(path), path
            assert path_of(file_uri(text)) == text
            checked += 1
    assert checked > 400


def test_paths_become_absolute_without_following_links(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to("real")
    monkeypatch.chdir(tmp_path)
    assert file_uri("link/../link/./a b.step") == f"file://{tmp_path}/link/a%20b.step"


@pytest.mark.parametrize(
    ("text", "path"),
    [
        ("file:///a%20b%ff.step", "/a b\udcff.step"),
        ("FILE://localhost/a", "/a"),
        ("/a%20b", "/a%20b"),
        ("a:b/c", "a:b/c"),
        ("relative", "relative"),
    ],
)
def test_what_a_uri_names(text: str, path: str) -> None:
    assert path_of(text) == path


@pytest.mark.parametrize(
    "text", ["trash:///a", "file://elsewhere/a", "file://", "file:///a%00b", "http://x/y"]
)
def test_what_is_no_file_here_is_refused(text: str) -> None:
    with pytest.raises(ValueError):
        path_of(text)
