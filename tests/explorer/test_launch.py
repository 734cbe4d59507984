"""The command `explore`, its static build, and the frame in a notebook."""

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import restitution as rs
from commands import done, refused
from refusals import named
from restitution.explorer import answers, launch
from restitution.explorer.downloads import download
from restitution.paper import claims, reproduction
from restitution.paper.figures import Computation
from sockets import get, opened

TEXT = download({"what": "case", "state": {"impact.velocity": 0.123}})["text"]


def test_a_notebook_shows_a_frame_that_closes(monkeypatch):
    monkeypatch.setattr(launch, "warm_up", lambda: None)
    impact = answers.case_of({"impact.velocity": 0.123}).impact
    with rs.explore(impact, height=500) as page:
        html = page._repr_html_()
        assert f'<iframe src="{page.address}" width="100%" height="500"' in html
        assert page.address in repr(page)
        with opened(page._running) as socket:
            assert socket.schema["state"]["impact.velocity"] == 0.123
            assert socket.schema["state"]["material.equilibrium_modulus"] == 1e7
        policy = get(page._running, f"/?token={page._running.access.token}").headers["content-security-policy"]
        assert "frame-ancestors http://localhost:* http://127.0.0.1:*" in policy
        assert not page.closed
    assert page.closed
    assert repr(page) == "<Explorer: closed>"
    page.close()


def test_a_notebook_takes_a_case_file_too(tmp_path, monkeypatch):
    monkeypatch.setattr(launch, "warm_up", lambda: None)
    path = tmp_path / "ball.toml"
    path.write_text('title = "A ball"\n' + TEXT)
    for start in (path, str(path), rs.read_case(path)):
        with rs.explore(start) as page, opened(page._running) as socket:
            assert socket.schema["title"] == "A ball"
            assert socket.schema["state"]["material.model"] == "standard_solid"
    with pytest.raises(rs.InputError, match="must be an Impact or the name of a case file"):
        rs.explore(3)  # pyright: ignore[reportArgumentType]
    assert named(lambda: rs.explore(height=-1)) == ("height", -1)


def test_the_case_of_an_indentation_opens_in_its_tab(tmp_path, monkeypatch):
    monkeypatch.setattr(launch, "warm_up", lambda: None)
    path = tmp_path / "gel.toml"
    path.write_text(
        'title = "A gel"\n' + download({"what": "indentation", "state": {"indentation.depth": 1.23e-7}})["text"]
    )
    with rs.explore(path) as page, opened(page._running) as socket:
        assert socket.schema["title"] == "A gel"
        assert socket.schema["state"]["page.tab"] == "indentation"
        assert socket.schema["state"]["indentation.depth"] == 1.23e-7


def test_missing_libraries_are_one_line(monkeypatch):
    monkeypatch.setitem(sys.modules, "uvicorn", None)
    message = 'the explorer needs starlette and uvicorn: pip install "restitution[web]"'
    assert refused("explore", "--no-browser") == message


def test_a_bad_case_is_one_line(tmp_path):
    path = tmp_path / "ball.toml"
    path.write_text(TEXT + "\n[counter_body]\nmass = 1.0\n")
    assert refused("explore", str(path), "--no-browser", "--port", "0").startswith("counter_body: ")


def test_the_static_build_is_whole(tmp_path, monkeypatch):
    monkeypatch.setattr(answers, "paper", lambda: {"claims": []})
    site = tmp_path / "site"
    done("explore", "--static", str(site))
    index = (site / "index.html").read_text()
    assert '<meta name="restitution" content="static">' in index
    for name in re.findall(r'(?:src|href)="(static/[^"]+)"', index):
        assert (site / name).is_file()
    assert json.loads((site / "static" / "schema.json").read_text())["kind"] == "schema"
    assert {"interpolant.json", "interpolant.js", "paper.json"} <= {path.name for path in (site / "static").iterdir()}
    # No address of another host is in the page itself.
    for path in site.rglob("*.js"):
        assert not re.findall(r"https?://(?!www\.w3\.org)[\w.]+", path.read_text(encoding="utf-8"))


def test_the_static_build_takes_no_case(tmp_path):
    assert "leave a.toml out" in refused("explore", "a.toml", "--static", str(tmp_path))


@pytest.mark.slow
def test_the_claims_are_those_of_the_reproduction():
    shown = {claim["name"]: claim for claim in answers.paper()["claims"]}
    assert [claim["holds"] for claim in shown.values()] == [True] * 7
    for claim in (claims.large_near_half(Computation(reproduction.DEFAULT_SEED)), claims.stiffer()):
        assert shown[claim.name]["finding"] == claim.finding
    # The page of the documentation is that of the same run.
    page = (Path(__file__).parents[2] / "docs" / "_static" / "claims.md").read_text()
    for claim in shown.values():
        assert claim["finding"] in page


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals of Unix")
def test_ctrl_c_ends_the_command_at_once(tmp_path):
    path = tmp_path / "ball.toml"
    path.write_text(TEXT)
    command = [sys.executable, "-m", "restitution", "explore", str(path), "--no-browser", "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        address = process.stdout.readline().strip()
        match = re.fullmatch(r"http://127\.0\.0\.1:(\d+)/\?token=([\w-]{22})", address)
        assert match
        from websockets.sync.client import connect

        # A page that is open, and computes, does not hold the end up.
        here = f"127.0.0.1:{match[1]}"
        with connect(f"ws://{here}/ws?token={match[2]}", origin=f"http://{here}") as socket:  # pyright: ignore
            schema = json.loads(socket.recv(timeout=30))
            assert schema["state"]["impact.velocity"] == 0.123
            for number in range(50):
                socket.send(json.dumps({"id": number, "kind": "surface"}))
            os.kill(process.pid, signal.SIGINT)
            # The page stays open here, so that a server which waits for it would never end.
            process.wait(60)
        assert process.returncode == 0
        errors = process.stderr.read().splitlines()
        assert errors == ["Ctrl-C ends the server"]
