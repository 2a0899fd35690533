"""The reason why a connection fails, in words: gRPC shows it only in its own log."""

import os
import socket
import ssl
from typing import Optional

from .settings import CA, CERTIFICATE, KEY, Settings

#: Start of an HTTP/2 connection, with an empty frame of settings.
PREFACE = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + bytes([0, 0, 0, 4, 0, 0, 0, 0, 0])
#: Kind of the first frame of a server.
SETTINGS = 4
#: Variables that make gRPC use a proxy, unless no_proxy names the host.
PROXIES = ("grpc_proxy", "https_proxy", "http_proxy")


def why(settings: Settings, timeout: float) -> Optional[str]:
    """The cause of a failure; None if unknown. timeout: of each step, s."""
    cause = _why_direct(settings, timeout)
    proxy = next((name for name in PROXIES if os.environ.get(name)), None)
    if cause is None and proxy:
        return f"{settings.url} answers, but not through the proxy of {proxy}: add {settings.host} to no_proxy"
    return cause


def _why_direct(settings: Settings, timeout: float) -> Optional[str]:
    """Tries the connection without gRPC and without a proxy; None if it succeeds."""
    absent = f"no server answers at {settings.url}"
    advice = "check the address, or start counterpointd"
    try:
        connection = socket.create_connection((settings.host, settings.port), timeout)
    except OSError as error:
        return f"{absent} ({error.strerror or error}): {advice}"
    with connection:
        if settings.context:
            return _why_encrypted(settings, settings.context, connection, timeout)
        if _answers(connection):
            return None
    if _answers_encrypted(settings, timeout):
        return f"the server at {settings.url} expects TLS: give https:// in the address"
    return f"{absent}: the program at this address does not speak gRPC; {advice}"


def _why_encrypted(
    settings: Settings, context: ssl.SSLContext, connection: socket.socket, timeout: float
) -> Optional[str]:
    try:
        with context.wrap_socket(connection, server_hostname=settings.host) as encrypted:
            # With TLS 1.3 the server refuses the certificate of the client after the handshake.
            encrypted.sendall(PREFACE)
            encrypted.recv(9)
        return None
    except ssl.SSLCertVerificationError as error:
        cause = error.verify_message.rstrip(".")
        return (
            f"the certificate of the server at {settings.url} is not accepted ({cause}): check the host name in the "
            f"address, and the authorities in ca or {CA}"
        )
    except ssl.SSLError as error:
        if "CERTIFICATE" in (error.reason or "") or "UNKNOWN_CA" in (error.reason or ""):
            return _why_refused(settings)
        cause = str(error.reason or error)
    except OSError as error:
        cause = error.strerror or str(error)
    if _answers_plain(settings, timeout):
        return f"the server at {settings.url} answers without TLS: give http:// in the address"
    return f"the encrypted connection to {settings.url} fails ({cause}): check the address"


def _why_refused(settings: Settings) -> str:
    named = f"certificate and key, or {CERTIFICATE} and {KEY}"
    if settings.has_certificate:
        return f"the server at {settings.url} does not accept the certificate of the client: check {named}"
    return f"the server at {settings.url} requires a certificate of the client: give {named}"


def _answers(connection: socket.socket) -> bool:
    """Whether the server speaks HTTP/2."""
    try:
        connection.sendall(PREFACE)
        head = connection.recv(9)
    except OSError:
        return False
    return len(head) > 3 and head[3] == SETTINGS


def _answers_plain(settings: Settings, timeout: float) -> bool:
    try:
        with socket.create_connection((settings.host, settings.port), timeout) as connection:
            return _answers(connection)
    except OSError:
        return False


def _answers_encrypted(settings: Settings, timeout: float) -> bool:
    """Whether a handshake succeeds, with any certificate."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    try:
        with socket.create_connection((settings.host, settings.port), timeout) as connection:
            with context.wrap_socket(connection, server_hostname=settings.host):
                return True
    except OSError:
        return False
