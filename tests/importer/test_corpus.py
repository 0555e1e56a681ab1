"""Every real model: the face counts of the manifest, and a reason for what has none."""

from pathlib import Path

import conftest
import pytest

from trimray.importer import EmptyError

# What our reader gets where plain OpenCascade gets nothing (see MANIFEST.tsv: "reads it but gets no faces").
_OURS = {"stepcode+stepcode/TAIL.stp": 60, "vrsys+gpucast/teapot.igs": 32}


@pytest.mark.corpus
@pytest.mark.skipif(
    conftest.models_folder() is None, reason="TRIMRAY_MODELS does not name a folder with a MANIFEST.tsv"
)
@pytest.mark.parametrize("row", conftest.manifest(), ids=lambda row: Path(row["path"]).name)
def test_all_faces_arrive(read_here, real_model, row):
    expected = _OURS.get(row["path"], int(row["ocp_faces"] or 0))
    if expected == 0:
        with pytest.raises(EmptyError) as caught:
            read_here(real_model(row["path"]))
        assert [i for i in caught.value.report["issues"] if i["severity"] == "error"]
        return
    model = read_here(real_model(row["path"]))
    assert model.report["face_uses"] == expected
    assert model.report["faces_in_file"] == model.report["faces"]
    model.validate()
