"""An OpenAI-compatible chat endpoint, by httpx: one question, one reply, never after its time.

Requests run on an event loop in a thread of their own, so that the time allowed bounds a call as a
whole, however slowly a reply trickles in. What can go wrong is mapped once, to `CallFailed`.
"""

import asyncio
import contextlib
import json
import threading
from concurrent.futures import CancelledError
from concurrent.futures import TimeoutError as Late
from dataclasses import dataclass, replace
from typing import Any

import httpx

REPLY_BYTES = 1 << 20  # a longer reply is given up
ATTEMPTS = 6  # ways of putting a request that are tried in one call
GRACE_S = 0.25  # after which a call is abandoned whatever its loop does
LONGEST_REST_S = 300.0
WINDOW = 6  # characters of a key that may stand in a text together: one less


class CallFailed(Exception):
    """No reply; str() is the cause in a few words. `billable`: it may have cost something.
    `transient`: trying again at once would be no use, later may be; `rest_s` when it was told."""

    def __init__(
        self, cause: str, billable: bool = False, transient: bool = False, rest_s: float = 0.0
    ) -> None:
        super().__init__(cause)
        self.billable, self.transient, self.rest_s = billable, transient, rest_s


@dataclass(frozen=True)
class Reply:
    """What the model said, and what the endpoint says it took (None: it does not say)."""

    text: str
    tokens_in: int | None
    tokens_out: int | None


@dataclass(frozen=True)
class _Shape:
    """How a request is put: what servers accept differs, and is found out by asking."""

    form: int = 0
    limit: str = "max_tokens"
    temperature: bool = True


def _forms(schema: dict[str, Any]) -> list[dict[str, Any] | None]:
    """Ways of asking for an answer by a schema, the strictest first."""
    named = {"name": "recommendation", "strict": True, "schema": schema}
    return [
        {"type": "json_schema", "json_schema": named},  # OpenAI, vLLM, llama-server
        {"type": "json_object", "schema": schema},  # llama-cpp-python's server
        {"type": "json_object"},
        None,
    ]


class Endpoint:
    """One model of one server. Threads may share it; connections are kept between calls."""

    def __init__(self, base_url: str, model: str, key: str = "") -> None:
        self._url, self._model, self._key = base_url.rstrip("/") + "/chat/completions", model, key
        self._shape = _Shape()  # of the last call that was answered; only the loop touches it
        headers = {"Accept-Encoding": "identity"}  # nothing that unpacks to more than was read
        if key:
            headers["Authorization"] = f"Bearer {key}"
        self._client = httpx.AsyncClient(
            headers=headers,
            limits=httpx.Limits(max_connections=8, max_keepalive_connections=4),
            follow_redirects=False,  # the key is for this server only
            trust_env=base_url.startswith("https"),  # a proxy could read what is sent over http
        )
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._run, name="cloud", daemon=True)
        self._thread.start()

    def chat(
        self,
        messages: list[dict[str, Any]],
        schema: dict[str, Any],
        max_tokens: int,
        within_s: float,
    ) -> Reply:
        """Ask, and wait for at most `within_s` (and GRACE_S). Raises CallFailed."""
        if not self._thread.is_alive():
            raise CallFailed("closed")
        asking = self._ask(messages, schema, max_tokens, within_s)
        future = asyncio.run_coroutine_threadsafe(asking, self._loop)
        try:
            return future.result(within_s + GRACE_S)
        except (Late, CancelledError):
            future.cancel()
            raise CallFailed("late", billable=True, transient=True) from None

    def close(self) -> None:
        """Abandon what is under way and close the connections."""
        if self._thread.is_alive():
            self._loop.call_soon_threadsafe(self._loop.stop)
            self._thread.join(timeout=1.0)

    # -- the loop's thread ---------------------------------------------------------------------

    def _run(self) -> None:
        self._loop.run_forever()
        self._loop.run_until_complete(self._end())
        self._loop.close()

    async def _end(self) -> None:
        tasks = asyncio.all_tasks() - {asyncio.current_task()}
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        with contextlib.suppress(httpx.HTTPError):
            await self._client.aclose()
        for _ in range(3):
            await asyncio.sleep(0)  # a transport closes its socket in a later turn of the loop

    async def _ask(
        self,
        messages: list[dict[str, Any]],
        schema: dict[str, Any],
        max_tokens: int,
        within_s: float,
    ) -> Reply:
        try:
            async with asyncio.timeout(within_s):
                return await self._settle_on_a_shape(messages, schema, max_tokens, within_s)
        except TimeoutError:
            raise CallFailed("late", billable=True, transient=True) from None
        except (httpx.ConnectTimeout, httpx.PoolTimeout):
            raise CallFailed("late", transient=True) from None
        except httpx.TimeoutException:
            raise CallFailed("late", billable=True, transient=True) from None
        except httpx.ConnectError:
            raise CallFailed("cannot be reached", transient=True) from None
        except (httpx.HTTPError, httpx.InvalidURL) as error:
            cause = f"the connection broke ({type(error).__name__})"
            raise CallFailed(cause, billable=True, transient=True) from None

    async def _settle_on_a_shape(
        self,
        messages: list[dict[str, Any]],
        schema: dict[str, Any],
        max_tokens: int,
        within_s: float,
    ) -> Reply:
        """Ask as the last answered call was; when the server refuses the way it is put, in another
        way."""
        shape, forms = self._shape, _forms(schema)
        for _ in range(ATTEMPTS):
            body: dict[str, Any] = {"model": self._model, "messages": messages}
            body[shape.limit] = max_tokens
            if shape.temperature:
                body["temperature"] = 0
            if forms[shape.form] is not None:
                body["response_format"] = forms[shape.form]
            status, headers, said = await self._post(body, within_s)
            if status == 200:
                reply = _reply(said)
                self._shape = shape
                return reply
            # llama-cpp-python's server calls a request that it does not understand its own error.
            unfit = status in (400, 422) or (status == 500 and "response_format" in said)
            other = _other(shape, said, len(forms)) if unfit else None
            if other is None:
                raise self._refused(status, headers, said)
            shape = other
        raise CallFailed("refuses every form of the request")

    async def _post(self, body: dict[str, Any], within_s: float) -> tuple[int, httpx.Headers, str]:
        # less to connect: what never reached the server is known to cost nothing
        times = httpx.Timeout(within_s, connect=0.8 * within_s)
        async with self._client.stream("POST", self._url, json=body, timeout=times) as response:
            said = bytearray()
            async for chunk in response.aiter_raw():
                said += chunk
                if len(said) > REPLY_BYTES:
                    raise CallFailed(f"the reply is longer than {REPLY_BYTES} bytes", billable=True)
            return response.status_code, response.headers, said.decode("utf-8", "replace")

    def _refused(self, status: int, headers: httpx.Headers, said: str) -> CallFailed:
        if status in (401, 403):  # what else it says may quote the key
            return CallFailed(f"the key is refused ({status})", transient=True)
        if status == 404:
            return CallFailed("not found (404): check cloud.base_url and cloud.model", False, True)
        if status == 429:
            return CallFailed("rate limited (429)", transient=True, rest_s=_rest_s(headers))
        if status >= 500:
            rest_s = _rest_s(headers)
            return CallFailed(f"server error ({status})", True, transient=True, rest_s=rest_s)
        if 300 <= status < 400:
            return CallFailed(f"redirects ({status}): give the address it leads to", False, True)
        told = scrubbed(_complaint(said), self._key)
        cause = f"refused ({status}): {told}" if told else f"refused ({status})"
        return CallFailed(cause, transient=status != 400)


def _other(shape: _Shape, said: str, forms: int) -> _Shape | None:
    """Another way of putting a request that was refused with these words, if there is one."""
    if shape.limit == "max_tokens" and "max_completion_tokens" in said:
        return replace(shape, limit="max_completion_tokens")
    if shape.temperature and "temperature" in said:
        return replace(shape, temperature=False)
    return replace(shape, form=shape.form + 1) if shape.form + 1 < forms else None


def _reply(said: str) -> Reply:
    try:
        body = json.loads(said)
        content = body["choices"][0]["message"]["content"]
        usage = body.get("usage") or {}
    except (ValueError, RecursionError, LookupError, TypeError, AttributeError):
        raise CallFailed("nonsense: not a chat completion", billable=True) from None
    if isinstance(content, list):  # parts
        texts = [part.get("text") for part in content if isinstance(part, dict)]
        content = "".join(text for text in texts if isinstance(text, str))
    text = content if isinstance(content, str) else ""
    usage = usage if isinstance(usage, dict) else {}
    return Reply(text, _count(usage.get("prompt_tokens")), _count(usage.get("completion_tokens")))


def _count(value: object) -> int | None:
    whole = isinstance(value, int) and not isinstance(value, bool)
    return value if whole and 0 <= value <= 10**9 else None  # type: ignore[operator,return-value]


def _rest_s(headers: httpx.Headers) -> float:
    """Retry-After in seconds (RFC 9110); a date or nonsense is 0."""
    text = headers.get("retry-after", "")
    return min(float(text), LONGEST_REST_S) if text.isascii() and text.isdigit() else 0.0


def _complaint(said: str) -> str:
    """The server's own words in a refusal, on one line."""
    try:
        body = json.loads(said)
        error = body.get("error", body.get("detail", body.get("message", "")))
        told = error.get("message", "") if isinstance(error, dict) else error
    except (ValueError, RecursionError, AttributeError):
        told = ""
    line = " ".join("".join(c if c.isprintable() else " " for c in str(told)).split())
    return line[:2000]


def scrubbed(text: str, key: str, limit: int = 160) -> str:
    """At most `limit` characters of a text, without the key or any WINDOW characters of it that
    stand together."""
    width = min(WINDOW, len(key))
    hidden = bytearray(len(text))
    for start in range(len(key) - width + 1) if key else ():
        part, at = key[start : start + width], -1
        while (at := text.find(part, at + 1)) >= 0:
            hidden[at : at + width] = b"\x01" * width
    shown = "".join("\0" if mark else c for mark, c in zip(hidden, text, strict=True))
    while "\0\0" in shown:
        shown = shown.replace("\0\0", "\0")
    return shown.replace("\0", "***")[:limit]
