"""A run that ends early has an outcome, which is a result: exit code 0, the outcome on stdout, advice on stderr."""


def test_a_start_beyond_a_guard(call, scene, tmp_path):
    scene.write_text(scene.read_text().replace("[analysis.motion]", "[system.initial]\ny = 5.0\n[analysis.motion]"))
    scene.write_text(scene.read_text().replace('"moving"', '"moving"\ncontact = "newton"'))
    answer = call("run", scene, "-o", tmp_path / "out.nc")
    assert answer.code == 0
    assert "outcome invalid_start" in answer.out
    assert "beyond a guard" in answer.err
    assert (tmp_path / "out.nc").exists()


def test_a_run_that_escapes(call, scene, tmp_path):
    scene.write_text(
        scene.read_text().replace("eta = 0.8", "eta = 0.8\nb = 3.0").replace("periods = 3", "periods = 300")
    )
    answer = call("run", scene, "-o", tmp_path / "out.nc")
    assert answer.code == 0
    assert "outcome escaped" in answer.out
    assert "left its bounds" in answer.err
    assert (tmp_path / "out.nc").exists()


def test_the_help_says_so(call):
    text = " ".join(call("run", "--help").out.split())
    assert "exit code is 0 also for a run that ends early" in text
    assert "0 success, whatever the outcome" in " ".join(call("--help").out.split())
