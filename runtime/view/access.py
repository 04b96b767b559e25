"""Who may look and ask: on this computer whoever has it, beyond it whoever has the token, over TLS;
and no page but our own."""

import hmac
import ssl
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from runtime.errors import ConfigError
from runtime.robot.endpoints import is_loopback

DEFAULT_LISTEN: Final = "127.0.0.1:8080"
LOOPBACK_NAMES: Final = ("127.0.0.1", "localhost", "::1")
TOKEN_CHARS: Final = (16, 512)
REMEDY: Final = "give --certificate, --key and --token-file (docs/view.md)"
CSP: Final = "; ".join(
    (
        "default-src 'none'",
        "script-src 'self'",
        "style-src 'self'",
        "img-src 'self' blob: data:",
        "connect-src 'self'",
        "manifest-src 'self'",
        "font-src 'self'",
        "base-uri 'none'",
        "form-action 'none'",
        "frame-ancestors 'none'",
    )
)
HEADERS: Final[Mapping[str, str]] = {
    "content-security-policy": CSP,
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "cache-control": "no-cache",
}


@dataclass(frozen=True)
class Access:
    """`names`: what a browser may call us, with port; `token`: "" for none."""

    host: str
    port: int
    names: frozenset[str]
    token: str = ""
    certificate: Path | None = None
    key: Path | None = None

    @property
    def scheme(self) -> str:
        return "https" if self.certificate is not None else "http"

    def host_allowed(self, host: str) -> bool:
        """Whether a request's Host is one of our names: a name that somebody has led to our address
        is not."""
        return host.lower() in self.names

    def origin_allowed(self, origin: str, host: str) -> bool:
        """Whether what asks is our own page. A browser always says who asks; what says nothing is
        refused."""
        return self.host_allowed(host) and origin.lower() == f"{self.scheme}://{host.lower()}"

    def token_right(self, given: object) -> bool:
        """Takes as long whatever is wrong with it."""
        if not self.token:
            return True
        told = given if isinstance(given, str) else ""
        return hmac.compare_digest(told.encode("utf-8", "replace"), self.token.encode())

    def bearer_right(self, authorization: str) -> bool:
        """The same of a request's header, "" where it has none."""
        kind, _, token = authorization.partition(" ")
        return self.token_right(token if kind.lower() == "bearer" else None)


def access(
    listen: str,
    certificate: Path | None,
    key: Path | None,
    token_file: Path | None,
    names: Iterable[str] = (),
) -> Access:
    """ConfigError, one line, for what would be open to strangers or cannot be used. `names`: others
    that the address is called by."""
    host, port = _address(listen)
    if (certificate is None) != (key is None):
        raise ConfigError("--certificate and --key go together")
    beyond = not is_loopback(host)
    if beyond and (certificate is None or token_file is None):
        raise ConfigError(
            f"--listen {listen}: beyond this computer all could see the home and drive the robot: "
            f"{REMEDY}"
        )
    token = _token(token_file) if token_file is not None else ""
    if certificate is not None and key is not None:
        _check(certificate, key)
    every = [*names, *([] if host in ("0.0.0.0", "::") else [host])]
    every += LOOPBACK_NAMES if not beyond or host in ("0.0.0.0", "::") else ()
    told = frozenset(named for name in every for named in _named(name, port, certificate))
    return Access(host, port, told, token, certificate, key)


def _address(listen: str) -> tuple[str, int]:
    host, colon, port = listen.rpartition(":")
    host = host.removeprefix("[").removesuffix("]")
    if not (colon and host and port.isdecimal() and len(port) <= 5 and 0 < int(port) < 65536):
        raise ConfigError(f"--listen {listen}: is no address: {DEFAULT_LISTEN}")
    return host, int(port)


def _named(name: str, port: int, certificate: Path | None) -> tuple[str, ...]:
    """As a browser writes it in Host."""
    bare = f"[{name}]" if ":" in name else name.lower()
    usual = 443 if certificate is not None else 80
    return (f"{bare}:{port}", bare) if port == usual else (f"{bare}:{port}",)


def _token(path: Path) -> str:
    try:
        if path.stat().st_mode & 0o077:
            raise ConfigError(f"--token-file: others can read {path}; run chmod 600 on it")
        token = path.read_text(encoding="ascii").strip()
    except (OSError, UnicodeDecodeError) as error:
        why = error.strerror if isinstance(error, OSError) else "is not ASCII"
        raise ConfigError(f"--token-file: {path}: {why}") from error
    least, most = TOKEN_CHARS
    if not least <= len(token) <= most or not token.isprintable() or " " in token:
        raise ConfigError(
            f"--token-file: {path}: must be {least} to {most} letters and digits, e.g. of "
            "`openssl rand -hex 16`"
        )
    return token


def _check(certificate: Path, key: Path) -> None:
    try:
        if key.stat().st_mode & 0o007:
            raise ConfigError(f"--key: others can read {key}; run chmod 600 on it")
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.load_cert_chain(certificate, key, lambda: "")
    except ssl.SSLError as error:
        raise ConfigError(f"--certificate: {certificate}: does not go with {key}") from error
    except OSError as error:
        raise ConfigError(f"--certificate: {certificate}, {key}: {error.strerror}") from error
