"""Where a model elsewhere is, what it may cost and see, and its key, which stays in its file."""

import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal
from urllib.parse import urlsplit

from runtime.errors import ConfigError

KEY_CHARS = 4096
LOOPBACK = ("localhost", "127.0.0.1", "::1")


@dataclass(frozen=True)
class CloudConfig:
    """[cloud]: a model elsewhere, by an OpenAI-compatible endpoint. Nothing is sent unless
    `enabled`."""

    enabled: bool = False
    base_url: str = ""  # up to and with /v1, e.g. "https://api.example.com/v1"
    model: str = ""  # as the endpoint calls it
    key_file: str = ""  # file that holds the key and that others cannot read
    credential: str = ""  # or a systemd credential: a file in $CREDENTIALS_DIRECTORY
    price_in_usd: float = -1.0  # per million tokens; 0 for a server of one's own
    price_out_usd: float = -1.0
    cap_goal_usd: float = 0.05
    cap_day_usd: float = 0.50
    spending_file: str = ""  # SQLite; "" is one in RF-NAV's state
    privacy: Literal["text", "full"] = "text"  # "text": no image leaves the robot
    images: bool = True  # with privacy "full", whether SLE sends its pictures
    image_tokens: int = 1600  # the most that one image is billed as
    reply_tokens: int = 300
    timeout_s: float = 20.0  # of a call, where the decision allows more
    local_share: float = 0.4  # of a decision's time, that local models have before the cloud
    on_disagreement: bool = True  # asked too when the local votes do not agree

    @property
    def sends_images(self) -> bool:
        return self.enabled and self.privacy == "full" and self.images


def check(cfg: CloudConfig) -> None:
    """ConfigError, one line, when it cannot be used. No value that might be a key is told."""
    if not cfg.enabled:
        return
    try:
        parts = urlsplit(cfg.base_url)
        known = parts.scheme in ("http", "https") and parts.hostname and parts.port != 0
    except ValueError:
        known = False
    if not known:
        raise ConfigError('cloud.base_url: must be like "https://api.example.com/v1"')
    if parts.username or parts.password or parts.query or parts.fragment:
        raise ConfigError(
            "cloud.base_url: must be an address only; the key belongs in cloud.key_file"
        )
    if not cfg.model:
        raise ConfigError("cloud.model: must be given, as the endpoint calls it")
    if cfg.key_file and cfg.credential:
        raise ConfigError("cloud.key_file and cloud.credential: give one of them")
    for name in ("price_in_usd", "price_out_usd"):
        if not 0 <= getattr(cfg, name) < 1e6:
            raise ConfigError(
                f"cloud.{name}: must be given, in US dollars per million tokens; "
                "0 for a server of your own"
            )
    for name, low, high in (
        ("cap_goal_usd", 0, 1e6),
        ("cap_day_usd", 0, 1e6),
        ("timeout_s", 0.1, 600),
        ("local_share", 0, 1),
        ("reply_tokens", 16, 100_000),
        ("image_tokens", 0, 1_000_000),
    ):
        value = getattr(cfg, name)
        if not low <= value <= high:
            raise ConfigError(f"cloud.{name}: is {value}, must be from {low:g} to {high:g}")
    has_key = bool(cfg.key_file or cfg.credential)
    if has_key and parts.scheme == "http" and parts.hostname not in LOOPBACK:
        raise ConfigError("cloud.base_url: a key is sent over https only, not over http")


def read_key(cfg: CloudConfig) -> str:
    """The key, from a file; "" when none is configured. ConfigError never tells what it read."""
    path, where = _key_path(cfg)
    if path is None:
        return ""
    try:
        if path.stat().st_mode & 0o007:
            raise ConfigError(f"{where}: others can read the file; run chmod 600 on it")
        text = path.read_text(encoding="utf-8")[: KEY_CHARS + 2].strip()
    except (OSError, ValueError):
        raise ConfigError(f"{where}: must name a file that holds the key and can be read") from None
    if not re.fullmatch(r"[\x21-\x7e]{1,%d}" % KEY_CHARS, text):  # noqa: UP031 -- braces
        raise ConfigError(f"{where}: the file must hold the key alone, on one line")
    return text


def _key_path(cfg: CloudConfig) -> tuple[Path | None, str]:
    if cfg.key_file:
        return Path(cfg.key_file).expanduser(), "cloud.key_file"
    if not cfg.credential:
        return None, ""
    directory = os.environ.get("CREDENTIALS_DIRECTORY")
    if not directory:
        raise ConfigError(
            "cloud.credential: $CREDENTIALS_DIRECTORY is not set; "
            "start from a systemd unit with LoadCredential="
        )
    if cfg.credential != Path(cfg.credential).name:
        raise ConfigError("cloud.credential: must be the name of a credential, not a path")
    return Path(directory) / cfg.credential, "cloud.credential"
