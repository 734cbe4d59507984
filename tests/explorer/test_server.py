"""The server: who may use it, what it serves, and what becomes of messages of any kind."""

import base64
import itertools
import json
import random
import socket
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus

import random_messages as fuzz
import restitution as rs
from refusals import named
from restitution.explorer import answers, server
from restitution.explorer.launch import listen
from restitution.explorer.server import page_files
from restitution.parallel import checkpoint
from sockets import get, opened


@pytest.mark.parametrize(
    "query",
    ["", "token=", "token={short}", "token={token}x", "token=wrong", "token=%00", "token=%C3%A4", "token=a&token={token}",
     "token={token}&token=a", "token={token}&token={token}"],
)  # fmt: skip
def test_the_page_and_its_socket_need_the_token_alone(running, query):
    token = running.access.token
    query = query.format(token=token, short=token[:-1])
    answer = get(running, f"/?{query}")
    assert answer.status == 403
    assert token.encode() not in answer.content
    with pytest.raises(InvalidStatus), opened(running, address=f"ws://127.0.0.1:{running.port}/ws?{query}"):
        pass


def test_tokens_are_random():
    servers = [listen(port=0) for _ in range(3)]
    for server_ in servers:
        server_.listener.close()
    assert len({server_.access.token for server_ in servers}) == 3
    assert all(len(server_.access.token) >= 22 for server_ in servers)


@pytest.mark.parametrize(
    "host",
    ["evil.com@127.0.0.1", "evil.com@127.0.0.1:{port}", "127.0.0.1/x", "127.0.0.1?x", "evil.example",
     "evil.example:{port}", "localhost.evil.example", "", "[", "127.0.0.1.nip.io"],
)  # fmt: skip
def test_other_names_of_this_machine_are_refused(running, host):
    host = host.format(port=running.port)
    for path in (f"/?token={running.access.token}", "/static/interpolant.js"):
        assert get(running, path, host=host).status in (400, 403)


@pytest.mark.parametrize("host", ["localhost:{port}", "127.0.0.1:{port}", "[::1]:{port}", "127.0.0.1"])
def test_addresses_and_localhost_are_served(running, host):
    assert get(running, f"/?token={running.access.token}", host=host.format(port=running.port)).status == 200


@pytest.mark.parametrize(
    "origin",
    [None, "http://evil.example", "null", "http://127.0.0.1:1", "http://localhost:{port}", "file://", "http://["],
)
def test_sockets_of_other_pages_are_refused(running, origin):
    with (
        pytest.raises(InvalidStatus) as refused,
        opened(running, origin=None if origin is None else origin.format(port=running.port)),
    ):
        pass
    assert refused.value.response.status_code == 403


def test_headers_forbid_what_the_page_does_not_need(running):
    for path in (f"/?token={running.access.token}", "/static/interpolant.js", "/nothing"):
        headers = get(running, path).headers
        policy = headers["content-security-policy"]
        assert "default-src 'none'; script-src 'self'; style-src 'self'" in policy
        assert "unsafe" not in policy
        assert "frame-ancestors 'none'" in policy
        assert headers["x-content-type-options"] == "nosniff"
        assert headers["referrer-policy"] == "no-referrer"
        assert headers["server"] is None


def test_the_page_has_no_inline_script_or_style():
    index = page_files()["index.html"].decode()
    assert "<style" not in index
    assert " style=" not in index
    assert " onclick=" not in index
    assert index.count("<script") == index.count('src="static/')
    assert '<meta name="restitution" content="live">' in index


@pytest.mark.parametrize(
    "path",
    ["/static/../server.py", "/static/..%2Fserver.py", "/static/%2e%2e/server.py", "/static//etc/passwd", "/server.py",
     "/static/", "/static/nothing.js", "/etc/passwd", "/static/__init__.py", "/static/page.js%00.py", "/schema"],
)  # fmt: skip
def test_no_other_file_is_served(running, path):
    answer = get(running, path)
    assert answer.status == 404
    assert b"import" not in answer.content


def test_all_files_of_the_page_are_served_with_their_type(running):
    for name in page_files():
        answer = get(running, f"/static/{name}")
        assert answer.status == 200
        assert answer.content == page_files()[name]
        assert not name.endswith(".js") or answer.headers["content-type"].startswith("text/javascript")


def test_only_reading_is_allowed(running):
    import http.client

    connection = http.client.HTTPConnection("127.0.0.1", running.port, timeout=10)
    connection.request("POST", f"/?token={running.access.token}", b"x" * 100)
    assert connection.getresponse().status == 405
    connection.close()


def test_the_schema_describes_every_number(running, ask):
    with opened(running) as socket_:
        schema = socket_.schema
    assert schema["kind"] == "schema"
    assert schema["version"] == rs.__version__
    dimensions = {about["dimension"] for about in schema["outputs"].values()}
    dimensions |= {about["dimension"] for about in schema["inputs"] if about["type"] != "choice"}
    for units in schema["units"].values():
        assert dimensions - set(units) <= {"energy per amount of substance"}
    for kind in ("impact", "velocity", "surface", "bounces", "indentation"):
        answer = ask(kind)
        names = set(answer.get("numbers", {}))
        for label, curve in answer["curves"].items():
            names |= set(curve) if label != "shape" else set()
        assert names - set(schema["outputs"]) <= {"radius"}


def test_curves_come_as_doubles(ask, monkeypatch):
    # The time of an answer decides its number of points.
    monkeypatch.setattr(answers, "TIME_LIMIT", 1e3)
    for kind in ("impact", "surface"):
        for name, expected in answers.KINDS[kind]({})["curves"].items():
            answered = ask(kind)["curves"][name]
            assert answered.keys() == expected.keys()
            for column in answered.keys() - {"displacement", "semi_axis", "unknown", "thickness", "range"}:
                doubles = np.frombuffer(base64.b64decode(answered[column]["doubles"]), "<f8")
                np.testing.assert_array_equal(doubles, expected[column])


def test_a_wrong_input_is_one_line_that_names_it(ask):
    answer = ask("impact", {"material.poisson_ratio": 0.7})
    assert answer == {
        "id": 1, "kind": "impact", "ok": False, "field": "material.poisson_ratio",
        "error": "material.poisson_ratio = 0.7: must be in [-1, 0.5]",
    }  # fmt: skip


def test_a_solve_that_fails_is_one_line(ask, monkeypatch):
    from restitution.impact.status import SolverError, Status

    def fail(*_, **__):
        raise SolverError(Status.TOO_MANY_STEPS, "at\nlast")

    monkeypatch.setattr(answers, "_solved", fail)
    answer = ask("impact", {"impact.velocity": 0.123})
    assert not answer["ok"]
    assert answer["error"] == str(SolverError(Status.TOO_MANY_STEPS, "at last"))


def test_a_mistake_of_the_program_ends_no_session(ask, monkeypatch):
    monkeypatch.setitem(server._KINDS, "impact", lambda _: {}["nothing"])
    assert server.BUG in ask("impact")["error"]
    assert ask("bounces")["ok"]


def test_requests_that_wait_are_replaced_by_newer_ones(running, monkeypatch):
    begun, go_on = threading.Event(), threading.Event()

    def slow(content):
        begun.set()
        assert go_on.wait(20)
        return {"number": content["number"]}

    monkeypatch.setitem(server._KINDS, "impact", slow)
    monkeypatch.setitem(server._KINDS, "velocity", lambda content: {"number": content["number"]})
    with opened(running) as page:
        page.send(json.dumps({"id": 0, "kind": "impact", "number": 0}))
        assert begun.wait(20)
        for number in range(1, 50):
            for kind in ("impact", "velocity"):
                page.send(json.dumps({"id": number, "kind": kind, "number": number}))
        # An answer to a bad message shows that all earlier messages were read.
        page.send("?")
        assert json.loads(page.recv(timeout=20))["kind"] is None
        go_on.set()
        answers_ = [json.loads(page.recv(timeout=20)) for _ in range(3)]
        assert [(answer["kind"], answer["id"]) for answer in answers_] == [
            ("impact", 0),
            ("impact", 49),
            ("velocity", 49),
        ]
        with pytest.raises(TimeoutError):
            page.recv(timeout=0.2)


def test_the_curve_over_velocity_waits_for_the_numbers_but_not_for_ever(running, monkeypatch):
    begun, go_on = threading.Semaphore(0), threading.Semaphore(0)
    clock = itertools.count()

    def slow(_):
        begun.release()
        return {"waited": go_on.acquire(timeout=20)}

    # A clock that advances by 1 at every request: the curve waits for three of them on a machine of any speed.
    monkeypatch.setattr(server, "time", SimpleNamespace(monotonic=lambda: next(clock), thread_time=time.thread_time))
    monkeypatch.setitem(server._QUICK, "velocity", 3.0)
    monkeypatch.setitem(server._KINDS, "impact", slow)
    monkeypatch.setitem(server._KINDS, "velocity", lambda _: {})
    with opened(running) as page:
        for kind in ("impact", "velocity"):
            page.send(json.dumps({"id": 0, "kind": kind}))
        kinds: list[str] = []
        # One impact is answered, and another one waits, at all times.
        while "velocity" not in kinds:
            assert begun.acquire(timeout=20)
            page.send(json.dumps({"id": 1, "kind": "impact"}))
            page.send("?")
            while (kind := json.loads(page.recv(timeout=20))["kind"]) is not None:
                kinds.append(kind)
            go_on.release()
            kinds.append(json.loads(page.recv(timeout=20))["kind"])
            assert len(kinds) < 300
        assert kinds.count("impact") > 1
        go_on.release()


@pytest.mark.parametrize(("kind", "same_page"), [("surface", True), ("paper", False)])
def test_a_slow_answer_holds_neither_a_slider_nor_another_page_up(running, monkeypatch, kind, same_page):
    go_on = threading.Event()
    monkeypatch.setitem(server._KINDS, kind, lambda _: {"waited": go_on.wait(20)})
    with opened(running) as slow, opened(running) as other:
        quick = slow if same_page else other
        slow.send(json.dumps({"id": 0, "kind": kind}))
        for number in range(1, 20):
            quick.send(json.dumps({"id": number, "kind": "impact"}))
            assert json.loads(quick.recv(timeout=20))["id"] == number
        go_on.set()
        assert json.loads(slow.recv(timeout=20))["waited"]


def test_the_newest_request_is_answered_when_the_turn_of_its_page_comes(running, monkeypatch):
    begun, go_on = threading.Event(), threading.Event()

    def slow(content):
        if content["number"] == 0:
            begun.set()
            assert go_on.wait(20)
        return {}

    monkeypatch.setitem(server._KINDS, "impact", slow)
    with opened(running) as first, opened(running) as second:
        first.send(json.dumps({"id": 0, "kind": "impact", "number": 0}))
        assert begun.wait(20)
        for number in range(1, 20):
            second.send(json.dumps({"id": number, "kind": "impact", "number": number}))
            assert json.loads(exchange(second, "?"))["kind"] is None
        go_on.set()
        assert json.loads(second.recv(timeout=20))["id"] == 19


def endless(_):
    for _ in range(2_000):
        checkpoint()
        time.sleep(0.01)
    pytest.fail("no checkpoint has ended the work")


def test_an_answer_that_takes_long_is_one_line(running, monkeypatch):
    monkeypatch.setitem(server._KINDS, "velocity", endless)
    monkeypatch.setattr(server, "LONGEST_WORK", 0.1)
    with opened(running) as page:
        page.send(json.dumps({"id": 1, "kind": "velocity"}))
        answer = json.loads(page.recv(timeout=20))
        assert answer["id"] == 1
        assert answer["error"] == "velocity: takes over 0.1 s with these inputs; `restitution solve` has no limit"
        page.send(json.dumps({"id": 2, "kind": "impact"}))
        assert json.loads(page.recv(timeout=20))["ok"]


def test_the_time_of_compilation_does_not_count(monkeypatch):
    # Half a minute between two checks counts as a second, and what is before the first one does not.
    times = iter((100.0, 130.0, 130.9, 131.8, 132.7, 133.6, 134.5))
    monkeypatch.setattr(server, "time", SimpleNamespace(monotonic=lambda: next(times)))
    check = server._limit("tapping", lambda: False)
    for _ in range(6):
        check()
    with pytest.raises(server._Ended, match=r"^takes over 5 s .*; `restitution tap` has no limit$"):
        check()


def test_a_newer_request_ends_the_work_on_an_older_one(running, monkeypatch):
    monkeypatch.setitem(server._KINDS, "impact", lambda content: endless(content) if "state" in content else {})
    with opened(running) as page:
        page.send(json.dumps({"id": 1, "kind": "impact", "state": {}}))
        page.send(json.dumps({"id": 2, "kind": "velocity", "state": {}}))
        time.sleep(0.1)
        page.send(json.dumps({"id": 3, "kind": "impact"}))
        # The first one has no answer, and the page needs none.
        assert {json.loads(page.recv(timeout=20))["id"] for _ in range(2)} == {2, 3}


def test_eight_pages_are_answered(running):
    results: dict[int, list[float]] = {}

    def drag(page: int) -> None:
        with opened(running) as socket_:
            answered = results[page] = []
            for step in range(5):
                state = {"impact.velocity": 0.1 + 0.01 * (5 * page + step)}
                socket_.send(json.dumps({"id": step, "kind": "impact", "state": state}))
                answer = json.loads(socket_.recv(timeout=60))
                assert answer["id"] == step
                answered.append(answer["numbers"]["restitution_coefficient"])

    threads = [threading.Thread(target=drag, args=(page,)) for page in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(120)
    e = [value for page in range(8) for value in results[page]]
    assert len(e) == 40
    # For this material e falls with the velocity.
    assert e == sorted(e, reverse=True)


@pytest.mark.parametrize(
    "message",
    ["", "{", "[]", "null", "1", '"impact"', "{}", '{"kind": 1}', '{"kind": "other"}', '{"kind": "impact", "state": []}',
     '{"id": [1], "kind": "impact"}', '{"id": 1e999, "kind": "impact"}', '{"id": -1e999, "kind": "impact", "state": {}}', '{"id": NaN, "kind": "impact"}', '{"kind": "impact", "state": {"impact.velocity": Infinity}}',
     "[" * 20_000, '{"a":' * 20_000, "9" * 20_000, b"\x00\xff"],
    ids=lambda message: str(message)[:20],
)  # fmt: skip
def test_what_is_no_request_gets_one_line(running, message):
    with opened(running) as page:
        page.send(message)
        answer = json.loads(page.recv(timeout=20))
        assert not answer["ok"]
        assert answer["error"].count("\n") == 0
        assert len(answer["error"]) < 300
        page.send(json.dumps({"id": "last", "kind": "impact"}))
        assert json.loads(page.recv(timeout=20))["ok"]


def test_a_long_message_is_one_line(running):
    with opened(running) as page:
        page.send(json.dumps({"id": 7, "kind": "impact", "state": {}, "more": "x" * server.LONGEST}))
        answer = json.loads(page.recv(timeout=20))
        assert answer["id"] == 7
        assert "must have at most 65536" in answer["error"]


def exchange(page, message: str) -> str:
    page.send(message)
    return page.recv(timeout=20)


def test_a_huge_message_ends_its_own_socket_alone(running):
    with opened(running) as other:
        # The server may end it before the message is sent; older clients raise a ValueError if they still send then.
        with opened(running) as page, pytest.raises((ConnectionClosed, ValueError)):
            exchange(page, "x" * 9_000_000)
        other.send(json.dumps({"id": 1, "kind": "impact"}))
        assert json.loads(other.recv(timeout=20))["ok"]


def bombard(running, seed: int, count: int) -> int:
    """Send random messages on one socket, and return the number of answers; each is checked."""
    rng, answered = random.Random(seed), 0
    with opened(running) as page:

        def receive() -> None:
            nonlocal answered
            while True:
                answer = json.loads(page.recv(timeout=120))
                answered += 1
                if answer["id"] == "last":
                    assert answer["ok"]
                    return
                if not answer["ok"]:
                    assert server.BUG not in answer["error"]
                    assert "Traceback" not in answer["error"]
                    assert "\n" not in answer["error"]
                    assert "/tmp" not in answer["error"]
                    assert "root:" not in json.dumps(answer)

        reader = threading.Thread(target=receive)
        reader.start()
        for number in range(count):
            page.send(fuzz.message(rng, number))
        time.sleep(0.2)
        page.send(json.dumps({"id": "last", "kind": "velocity", "state": {}}))
        reader.join(200)
        assert not reader.is_alive()
    return answered


@pytest.mark.parametrize("sizes", [[400], pytest.param([1000] * 10, marks=pytest.mark.slow)])
def test_random_messages_end_nothing(running, sizes):
    for seed, size in enumerate(sizes):
        assert bombard(running, seed, size) > 20
    with opened(running) as page:
        page.send(json.dumps({"id": 1, "kind": "impact"}))
        assert json.loads(page.recv(timeout=20))["ok"]


def test_a_port_that_is_taken_is_one_line():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(rs.InputError, match=rf"^port = {port}: cannot be listened on at 127.0.0.1"):
            listen(port=port)


def test_hosts_and_ports_that_do_not_exist_are_refused():
    assert named(lambda: listen(port=70000)) == ("port", 70000)
    assert named(lambda: listen(host="no such host", port=0)) == ("host", "no such host")


def test_an_answer_that_cannot_be_written_ends_no_session(ask, monkeypatch):
    monkeypatch.setitem(server._KINDS, "impact", lambda _: {"numbers": float("inf")})
    assert server.BUG in ask("impact")["error"]
    monkeypatch.undo()
    assert ask("impact")["ok"]


def test_a_task_that_fails_answers_and_goes_on(running, monkeypatch):
    true = server.answer

    def fail_once(request):
        if request.id == 1:
            raise RecursionError("too deep")
        return true(request)

    monkeypatch.setattr(server, "answer", fail_once)
    with opened(running) as page:
        page.send(json.dumps({"id": 1, "kind": "impact"}))
        answer = json.loads(page.recv(timeout=20))
        assert answer["id"] == 1
        assert server.BUG in answer["error"]
        page.send(json.dumps({"id": 2, "kind": "impact"}))
        assert json.loads(page.recv(timeout=20))["ok"]


def test_no_more_sockets_than_allowed_are_served(running, monkeypatch):
    monkeypatch.setattr(server, "MOST_SOCKETS", 2)
    with opened(running), opened(running):
        with pytest.raises(InvalidStatus), opened(running):
            pass
        assert get(running, f"/?token={running.access.token}").status == 200
    until = time.monotonic() + 20
    while time.monotonic() < until:
        try:
            with opened(running):
                return
        except InvalidStatus:
            time.sleep(0.05)
    raise AssertionError("a socket that closed still counts")
