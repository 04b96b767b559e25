"""Where the bus may be: in the clear on this computer alone, beyond it with the certificates of
both sides."""

import ipaddress
import os
import ssl
from dataclasses import dataclass
from pathlib import Path

from runtime.core.keys import key
from runtime.errors import ConfigError

LOOPBACK_NAME = "localhost"
HARMLESS = frozenset({"iface", "bind", "dscp", "so_rcvbuf", "so_sndbuf"})
"""What may be said of a TLS endpoint behind its `#`. Zenoh would take whose certificates count
from there, too."""


@dataclass(frozen=True)
class TlsConfig:
    """[bus.tls]: the certificates of endpoints `tls/HOST:PORT`, PEM; docs/security.md makes some.
    Whoever connects, either way, has to show one."""

    ca: str = key("", "Certificate of those who say who is on the bus: theirs alone count.")
    certificate: str = key("", "The robot's own certificate.")
    private_key: str = key("", "Its private key, in a file that others cannot read.")

    @property
    def named(self) -> dict[str, str]:
        """The files that are given, by key, as they are given."""
        given = {name: getattr(self, name) for name in ("ca", "certificate", "private_key")}
        return {name: os.path.expanduser(text) for name, text in given.items() if text}

    @property
    def paths(self) -> dict[str, Path]:
        """Where they are."""
        return {name: Path(os.path.expandvars(text)) for name, text in self.named.items()}


def check_endpoint(name: str, endpoint: str, tls: TlsConfig) -> None:
    """ConfigError for an endpoint, of the key `name`, that would open the bus to strangers."""
    protocol, _, rest = endpoint.partition("/")
    place, _, options = rest.partition("#")
    host = place.partition("?")[0].rpartition(":")[0]
    what = ""
    if protocol not in ("tcp", "tls") or not host:
        what = "is no endpoint: tcp/127.0.0.1:PORT, or tls/HOST:PORT"
    elif protocol == "tcp" and not is_loopback(host):
        what = (
            "is beyond this computer (127.0.0.1), where all could read it and drive the robot: use "
            f"tls/{place} with [bus.tls] (docs/security.md)"
        )
    elif protocol == "tls" and len(tls.paths) < 3:
        what = "needs bus.tls.ca, bus.tls.certificate and bus.tls.private_key (docs/security.md)"
    elif protocol == "tls":
        given = {option.partition("=")[0].strip() for option in options.split(";") if option}
        if given - HARMLESS:
            what = f"sets {min(given - HARMLESS)}: [bus.tls] alone says whose certificates count"
    if what:
        raise ConfigError(f"{name}: {endpoint!r} {what}")


def is_loopback(host: str) -> bool:
    """Whether an address, or "localhost", is this computer's own, whatever networks it is on. A
    name that has to be looked up is not."""
    try:
        return ipaddress.ip_address(host.removeprefix("[").removesuffix("]")).is_loopback
    except ValueError:
        return host == LOOPBACK_NAME


def check_files(tls: TlsConfig) -> None:
    """ConfigError, one line, when the certificates cannot be used, or the key lies open."""
    paths = tls.paths
    for name, path in paths.items():
        try:
            path.open("rb").close()
            if name == "private_key" and path.stat().st_mode & 0o007:
                raise ConfigError(f"bus.tls.{name}: others can read {path}; run chmod 600 on it")
        except OSError as error:
            raise ConfigError(f"bus.tls.{name}: {path}: {error.strerror}") from error
    try:
        context = ssl.create_default_context(cafile=paths["ca"])
    except (ssl.SSLError, OSError) as error:
        raise ConfigError(f"bus.tls.ca: {paths['ca']}: is no certificate in PEM") from error
    try:
        # A key with a passphrase would ask for it on the terminal; Zenoh takes none.
        context.load_cert_chain(paths["certificate"], paths["private_key"], lambda: "")
    except (ssl.SSLError, OSError) as error:
        raise ConfigError(
            f"bus.tls.certificate: {paths['certificate']}: does not go with "
            f"{paths['private_key']}: both in PEM, the key without a passphrase"
        ) from error
