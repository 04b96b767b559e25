/** The one connection to `rfnav view`. It opens itself again; what is asked is answered or fails. */

const SUBPROTOCOL = "rfnav.1";
const VERSION = 1;
const AGAIN_MS = [500, 1000, 2000, 5000];
const ANSWER_MS = 8000;
const POST_MS = 4000; // after which another is on its way: browsers send six at once, no more
const TOKEN_WANTED = 4401;
const TOKEN_KEY = "rfnav-token";

export class Link {
  /**
   * @param {{message: (m: object) => void, bytes: (b: ArrayBuffer) => void,
   *   opened: () => void, lost: (why: string) => void, token: () => Promise<string>}} heard
   */
  constructor(heard) {
    this.heard = heard;
    this.socket = null;
    this.tried = 0;
    this.asked = new Map();
    this.number = 0;
    this.token = tokenOfAddress() ?? stored();
  }

  open() {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(`${scheme}//${location.host}/ws`, SUBPROTOCOL);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      socket.send(JSON.stringify({ kind: "hello", v: VERSION, token: this.token }));
    };
    socket.onmessage = ({ data }) => this.#take(data);
    socket.onclose = (event) => this.#closed(event);
    this.socket = socket;
  }

  get up() {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  /** Not answered; lost where the link is down. */
  send(message) {
    if (this.up) this.socket.send(JSON.stringify(message));
  }

  /** The answer to a query; an Error of one line where it is refused or none comes. */
  ask(what, body = {}) {
    if (!this.up) return Promise.reject(new Error("Not connected: it was not sent."));
    const n = ++this.number;
    return new Promise((answered, failed) => {
      const timer = setTimeout(() => {
        this.asked.delete(n);
        failed(new Error("No answer came."));
      }, ANSWER_MS);
      this.asked.set(n, { answered, failed, timer });
      this.send({ kind: "do", n, what, body });
    });
  }

  /** Stop by both ways: whichever is through first. */
  stop() {
    const byPost = fetch("/stop", {
      method: "POST",
      headers: this.token ? { Authorization: `Bearer ${this.token}` } : {},
      signal: AbortSignal.timeout(POST_MS),
    }).then((reply) => {
      if (!reply.ok) throw new Error("The stop was not taken.");
    });
    return Promise.any([this.ask("stop"), byPost]);
  }

  #take(data) {
    if (data instanceof ArrayBuffer) {
      this.heard.bytes(data);
      return;
    }
    const message = JSON.parse(data);
    if (message.kind === "done") this.#done(message);
    else {
      if (message.kind === "welcome") {
        this.tried = 0;
        this.heard.opened();
      }
      this.heard.message(message);
    }
  }

  #done({ n, answer, error }) {
    const asked = this.asked.get(n);
    if (!asked) return;
    this.asked.delete(n);
    clearTimeout(asked.timer);
    const refused = error ?? (answer?.accepted === false ? answer.error : answer?.error);
    if (refused) asked.failed(new Error(refused));
    else asked.answered(answer);
  }

  async #closed({ code, reason }) {
    for (const { failed, timer } of this.asked.values()) {
      clearTimeout(timer);
      failed(new Error("The connection was lost."));
    }
    this.asked.clear();
    this.heard.lost(reason || "");
    if (code === TOKEN_WANTED) {
      this.token = await this.heard.token();
      sessionStorage.setItem(TOKEN_KEY, this.token);
      this.open();
      return;
    }
    const wait_ms = AGAIN_MS[Math.min(this.tried++, AGAIN_MS.length - 1)];
    setTimeout(() => this.open(), wait_ms);
  }
}

/** Of `#token=…`, which then leaves the address: it would stay in the history. */
function tokenOfAddress() {
  const token = new URLSearchParams(location.hash.slice(1)).get("token");
  if (!token) return null;
  history.replaceState(null, "", location.pathname);
  sessionStorage.setItem(TOKEN_KEY, token);
  return token;
}

function stored() {
  return sessionStorage.getItem(TOKEN_KEY);
}
