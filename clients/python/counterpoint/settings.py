"""The address of the server, the identity of the caller, and certificates.

Arguments take precedence over the environment variables, which the command line `counterpoint` also reads.
Invariant: no text of this module shows the token.
"""

import dataclasses
import os
import ssl
import urllib.parse
from typing import List, Optional, Tuple, Union

import grpc

StrPath = Union[str, "os.PathLike[str]"]

SERVER = "COUNTERPOINT_SERVER"
TOKEN = "COUNTERPOINT_TOKEN"
CA = "COUNTERPOINT_CA"
CERTIFICATE = "COUNTERPOINT_CLIENT_CERT"
KEY = "COUNTERPOINT_CLIENT_KEY"
TRACEPARENT = "TRACEPARENT"
DEFAULT = "http://127.0.0.1:7878"


@dataclasses.dataclass(frozen=True)
class Settings:
    """How to connect. context: for TLS without gRPC, which hides the cause of a failure; None without TLS."""

    url: str
    host: str
    port: int
    metadata: Tuple[Tuple[str, str], ...] = dataclasses.field(repr=False)
    credentials: Optional[grpc.ChannelCredentials]
    context: Optional[ssl.SSLContext]
    has_certificate: bool

    @property
    def target(self) -> str:
        """The address for gRPC."""
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"

    @property
    def has_token(self) -> bool:
        """Whether calls carry a token."""
        return any(key == "authorization" for key, _ in self.metadata)


def resolve(
    address: Optional[str],
    token: Optional[str],
    ca: Optional[StrPath],
    certificate: Optional[StrPath],
    key: Optional[StrPath],
    credentials: Optional[grpc.ChannelCredentials],
) -> Settings:
    """Settings from arguments and environment. Raises ValueError or OSError if they cannot be used."""
    given = ca is not None or certificate is not None or key is not None or credentials is not None
    address = address or os.environ.get(SERVER) or DEFAULT
    named = given or os.environ.get(CA) or os.environ.get(CERTIFICATE)
    scheme, host, port = _split(address, "https" if named else "http")
    if scheme == "http" and given:
        raise ValueError(f"certificates need TLS: give https:// in the address '{address}'")
    context, has_certificate = None, False
    if scheme == "https" and credentials is None:
        context, credentials, has_certificate = _tls(ca, certificate, key)
    elif credentials is not None:
        # The trusted authorities of the credentials are unknown here.
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    place = f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
    return Settings(f"{scheme}://{place}", host, port, _metadata(token), credentials, context, has_certificate)


def _split(address: str, scheme: str) -> Tuple[str, str, int]:
    """Scheme, host and port; scheme is the default."""
    expected = f"server address '{address}': expected HOST:PORT, http://HOST:PORT or https://HOST:PORT"
    explicit = "://" in address
    try:
        parts = urllib.parse.urlsplit(address if explicit else f"{scheme}://{address}")
        port = parts.port
    except ValueError:
        raise ValueError(expected) from None
    if explicit and port is None:
        port = 443 if parts.scheme == "https" else 80
    rest = parts.path.strip("/") or parts.query or parts.fragment or parts.username
    if parts.scheme not in ("http", "https") or not parts.hostname or port is None or rest:
        raise ValueError(expected)
    return parts.scheme, parts.hostname, port


def _metadata(token: Optional[str]) -> Tuple[Tuple[str, str], ...]:
    """Metadata of every call."""
    name = TOKEN if token is None else "token"
    token = (os.environ.get(TOKEN, "") if token is None else token).strip()
    metadata: List[Tuple[str, str]] = []
    if token:
        # gRPC would show the token in its message.
        if not (token.isascii() and token.isprintable()):
            raise ValueError(f"{name} has characters that no token has")
        metadata.append(("authorization", f"Bearer {token}"))
    parent = os.environ.get(TRACEPARENT, "").strip()
    if parent.isascii() and parent.isprintable() and parent:
        metadata.append(("traceparent", parent))
    return tuple(metadata)


def _tls(
    ca: Optional[StrPath], certificate: Optional[StrPath], key: Optional[StrPath]
) -> Tuple[ssl.SSLContext, grpc.ChannelCredentials, bool]:
    """TLS with the authorities of a file, otherwise those of the system."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.set_alpn_protocols(["h2"])
    roots = None
    named = _named("ca", ca, CA)
    if named:
        roots = _read(*named)
        try:
            context.load_verify_locations(cadata=roots.decode())
        except (ssl.SSLError, ValueError):
            raise ValueError(f"{named[0]}: '{named[1]}' is not a file of certificates (PEM)") from None
    else:
        context.load_default_certs()
        system = [ssl.DER_cert_to_PEM_cert(one) for one in context.get_ca_certs(binary_form=True)]
        roots = "".join(system).encode() or None
    own, secret = _named("certificate", certificate, CERTIFICATE), _named("key", key, KEY)
    if bool(own) != bool(secret):
        present = own or secret
        absent = f"key ({KEY})" if own else f"certificate ({CERTIFICATE})"
        raise ValueError(f"{present[0] if present else ''} is given without {absent}")
    if not own or not secret:
        return context, grpc.ssl_channel_credentials(roots), False
    chain, private = _read(*own), _read(*secret)
    try:
        # A key with a password must not ask for it on the terminal.
        context.load_cert_chain(own[1], secret[1], password="")
    except (ssl.SSLError, ValueError):
        text = f"'{own[1]}' and '{secret[1]}' are not a certificate and its key without a password (PEM)"
        raise ValueError(f"{own[0]}, {secret[0]}: {text}") from None
    return context, grpc.ssl_channel_credentials(roots, private, chain), True


def _named(name: str, path: Optional[StrPath], variable: str) -> Optional[Tuple[str, str]]:
    """The name and the value of a setting; None if neither argument nor environment has a value."""
    if path is not None:
        return name, os.fspath(path)
    value = os.environ.get(variable)
    return (variable, value) if value else None


def _read(name: str, path: str) -> bytes:
    try:
        with open(path, "rb") as file:
            return file.read()
    except FileNotFoundError:
        raise FileNotFoundError(f"{name}: '{path}' does not exist") from None
    except OSError as error:
        raise OSError(f"{name}: '{path}': {error.strerror}") from None
