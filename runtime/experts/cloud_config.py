"""Where a model elsewhere is, what it may cost and see, and its key, which stays in its file."""

import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal
from urllib.parse import urlsplit

from runtime.core.keys import key
from runtime.errors import ConfigError

KEY_CHARS = 4096
LOOPBACK = ("localhost", "127.0.0.1", "::1")


@dataclass(frozen=True)
class CloudConfig:
    """[cloud]: a model elsewhere, by an OpenAI-compatible endpoint. Nothing is sent unless
    `enabled`."""

    enabled: bool = key(False, "Nothing is sent, and nothing spent, unless this is true.")
    base_url: str = key(
        "", 'Where the model is, up to and with /v1, e.g. "https://api.example.com/v1".'
    )
    model: str = key("", "The model, as the endpoint calls it.")
    key_file: str = key("", "File that holds the key alone, and that others cannot read.")
    credential: str = key("", "Or a systemd credential: a file in $CREDENTIALS_DIRECTORY.")
    price_in_usd: float = key(
        -1.0,
        "Price of a million tokens sent; 0 for a server of one's own; below 0 is not given.",
        "USD",
        within=(-1.0, 1e6),
    )
    price_out_usd: float = key(
        -1.0, "Price of a million tokens received.", "USD", within=(-1.0, 1e6)
    )
    cap_goal_usd: float = key(0.05, "The most that one goal may cost.", "USD", within=(0.0, 1e6))
    cap_day_usd: float = key(
        0.50, "The most that a day, in UTC, may cost.", "USD", within=(0.0, 1e6)
    )
    privacy: Literal["text", "full"] = key(
        "text", '"text": no image leaves the robot; "full": SLE may send its pictures.'
    )
    timeout_s: float = key(
        20.0,
        "The longest that a call may take, where the decision allows more.",
        "s",
        research="cloud_timeout_s",
        within=(0.1, 600.0),
    )
    spending_file: str = key(
        "", "SQLite file of what was spent; \"\" is one in RF-NAV's state.",
        research="cloud_spending_file",
    )  # fmt: skip
    images: bool = key(
        True, 'With privacy "full", whether SLE sends its pictures.', research="cloud_images"
    )
    image_tokens: int = key(
        1600,
        "The most that one image is billed as.",
        "tokens",
        research="cloud_image_tokens",
        within=(0, 1_000_000),
    )
    reply_tokens: int = key(
        300,
        "The longest reply that is asked for.",
        "tokens",
        research="cloud_reply_tokens",
        within=(16, 100_000),
    )
    local_share: float = key(
        0.4, "Share of a decision's time that local models have before the cloud.",
        research="cloud_local_share",
        within=(0.0, 1.0),
    )  # fmt: skip
    on_disagreement: bool = key(
        True, "Whether the cloud is asked, too, when the local votes do not agree.",
        research="cloud_on_disagreement",
    )  # fmt: skip

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
        if not getattr(cfg, name) >= 0:
            raise ConfigError(
                f"cloud.{name}: must be given, in US dollars per million tokens; "
                "0 for a server of your own"
            )
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
