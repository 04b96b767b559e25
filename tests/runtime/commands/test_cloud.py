"""What a user sees of the cloud on the command line."""

from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from cloud_double import Server

from runtime.__main__ import cli
from runtime.errors import ConfigError

KEY = "sk-test-0123456789abcdef"


def written(tmp_path: Path, url: str, *lines: str) -> Path:
    key = tmp_path / "key"
    key.write_text(KEY)
    key.chmod(0o600)
    path = tmp_path / "robot.toml"
    told = (
        "[cloud]",
        "enabled = true",
        f'base_url = "{url}"',
        'model = "big"',
        f'key_file = "{key}"',
        "price_in_usd = 1.0",
        "price_out_usd = 10.0",
        f'spending_file = "{tmp_path}/spending.sqlite"',
        *lines,
    )
    path.write_text("\n".join(told))
    return path


def run(*arguments: str) -> Result:
    return CliRunner().invoke(cli, arguments, standalone_mode=False)


def test_a_question_and_its_price(tmp_path: Path) -> None:
    with Server() as server:
        path = written(tmp_path, server.url)
        done = run("cloud", "--config", str(path), "--ask")
        assert done.exit_code == 0, done.output
        assert "100 tokens in, 10 out, 0.0002 USD" in done.output
        assert "spent today: 0.0002 of 0.5 USD" in done.output
        assert "vote for 1 (1 is right): it looks right" in done.output
        again = run("cloud", "--config", str(path))
        assert "spent today: 0.0002 of 0.5 USD" in again.output
        assert len(server.requests) == 1
        assert KEY not in done.output + again.output


def test_no_answer_is_status_1(tmp_path: Path) -> None:
    with Server(lambda body: (429, "")) as server:
        done = run("cloud", "--config", str(written(tmp_path, server.url)), "--ask")
    assert done.exit_code == 1
    assert "no vote: rate limited (429)" in done.output


def test_a_cloud_that_is_not_allowed_is_said(tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    path.write_text("[cloud]\n")
    with pytest.raises(ConfigError, match=r"cloud\.enabled: is false"):
        raise run("cloud", "--config", str(path)).exception  # type: ignore[misc]


def test_check_looks_at_the_key_without_telling_it(tmp_path: Path) -> None:
    path = written(tmp_path, "https://example.com/v1")
    assert run("check", "--config", str(path)).output.endswith("robot.toml: ok\n")
    (tmp_path / "key").chmod(0o644)
    error = run("check", "--config", str(path)).exception
    assert isinstance(error, ConfigError)
    assert str(error) == "cloud.key_file: others can read the file; run chmod 600 on it"
