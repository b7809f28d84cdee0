"""A session as a page, for notebooks."""

import base64
import html
import json
import re
import socket
import urllib.request

import pytest

import handgraft
import handgraft.view

try:
    handgraft.view.web_folder()
except handgraft.InvalidInput as error:
    pytest.skip(str(error), allow_module_level=True)


def source_of(view, name):
    """What a notebook's frame would load."""
    return html.unescape(re.search(rf' {name}="([^"]*)"', view._repr_html_()).group(1))


def test_the_page_of_a_session_is_served(session):
    session.solve()
    view = session.view(height=480)
    assert re.fullmatch(rf"http://127\.0\.0\.1:\d+/\?session={session.id}", str(view))
    assert source_of(view, "src") == view.address
    assert 'height="480"' in view._repr_html_()
    with urllib.request.urlopen(view.address) as page:
        policy = page.headers["Content-Security-Policy"]
        assert "frame-ancestors 'self' http://localhost:*" in policy  # Jupyter's, on this machine
        assert b"page.js" in page.read()
    assert session.view().address == view.address, "one server of pages is enough"


def test_the_page_is_told_of_edits(session):
    """By hand over its WebSocket: the session is followed, and what Python edits comes."""
    session.solve()
    port = int(re.search(r":(\d+)/", session.view().address).group(1))
    with socket.create_connection(("127.0.0.1", port), timeout=20) as page:
        key = base64.b64encode(bytes(16)).decode()
        page.sendall((f"GET /live HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                      f"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {key}\r\n\r\n").encode())
        heard = b""

        def hear_until(wanted):
            nonlocal heard
            while wanted not in heard:
                part = page.recv(65536)
                assert part, f"the page is told {wanted}; it heard {heard[:500]}"
                heard += part

        hear_until(b"\r\n\r\n")  # a WebSocket says nothing before it is one
        text = json.dumps({"id": 1, "do": "follow", "session": session.id}).encode()
        page.sendall(bytes([0x81, 0x80 | len(text)]) + bytes(4) + text)
        hear_until(b'"reply":1')
        session.lock(session.joint_names[0])
        hear_until(b'"last_edit":"lock')


def test_a_view_that_is_kept_needs_no_server(session, tmp_path):
    with pytest.raises(handgraft.InvalidInput):
        session.view(live=False)  # nothing has been solved
    session.solve()
    view = session.view(live=False)
    assert view.address is None
    assert "barrett8" in view.html and "http://127.0.0.1" not in view.html
    assert source_of(view, "srcdoc") == view.html
    view.save(tmp_path / "grasp.html")
    assert (tmp_path / "grasp.html").read_text(encoding="utf-8") == view.html
    with pytest.raises(handgraft.InvalidInput):
        session.view().save(tmp_path / "live.html")
