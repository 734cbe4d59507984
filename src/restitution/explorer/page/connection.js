// The WebSocket. The server answers the newest request of a kind when its turn comes, and drops older ones that wait.
const PAUSES = [250, 500, 1000, 2000, 4000];

// An array of numbers comes as doubles in base64, little-endian; what is infinite or unknown becomes null.
function decoded(key, value) {
  if (typeof value?.doubles !== "string") return value;
  const text = atob(value.doubles);
  const bytes = new Uint8Array(text.length);
  for (let n = 0; n < text.length; n++) bytes[n] = text.charCodeAt(n);
  return Array.from(new Float64Array(bytes.buffer), (number) => (Number.isFinite(number) ? number : null));
}

export class Connection {
  // receive(answer, message) gets every answer with its request; report(word) gets "open", "closed" or "refused".
  constructor(receive, report) {
    Object.assign(this, { receive, report, id: 0, tries: 0, sent: new Map(), waiting: new Map() });
    this.listen();
    this.open();
  }

  open() {
    const address = new URL("ws", location.href);
    address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
    address.search = location.search;
    address.hash = "";
    this.opened = false;
    this.socket = new WebSocket(address);
    this.socket.onopen = () => {
      this.opened = true;
      this.news?.postMessage(location.search);
      this.tries = 0;
      this.report("open");
      for (const kind of this.waiting.keys()) this.next(kind);
    };
    this.socket.onmessage = (event) => this.answered(JSON.parse(event.data, decoded));
    this.socket.onclose = (event) => this.closed(event);
  }

  // A server that was started anew has another token. A page of the new address hands it to the pages of the old one:
  // the browser passes it to pages of the same name and port alone, and keeps it nowhere.
  listen() {
    this.news = window.BroadcastChannel && new BroadcastChannel("restitution explorer");
    if (!this.news) return;
    this.news.onmessage = ({ data }) => {
      const other = /^\?token=[\w-]+$/.test(data) && data !== location.search;
      if (other && this.socket.readyState !== WebSocket.OPEN) location.replace(`${location.pathname}${data}${location.hash}`);
    };
  }

  // What was on its way is asked again, unless something newer waits.
  closed(event) {
    for (const message of [...this.sent.values()].reverse()) {
      if (!this.queue(message.kind).has(message.channel)) this.queue(message.kind).set(message.channel, message);
    }
    this.sent.clear();
    const refused = event.code === 1008 || (!this.opened && this.tries > 2);
    this.report(refused ? "refused" : "closed");
    setTimeout(() => this.open(), PAUSES[Math.min(this.tries++, PAUSES.length - 1)]);
  }

  queue(kind) {
    if (!this.waiting.has(kind)) this.waiting.set(kind, new Map());
    return this.waiting.get(kind);
  }

  // The channel "main" goes first; others, such as those of pinned settings, follow when nothing newer waits.
  ask(kind, message, channel = "main") {
    this.id += 1;
    this.queue(kind).set(channel, { id: this.id, kind, channel, ...message });
    this.next(kind);
  }

  // A newer input follows an older one at once. A pinned setting must not be dropped for it, nor drop it.
  next(kind) {
    const queue = this.queue(kind);
    const channel = queue.has("main") ? "main" : queue.keys().next().value;
    const onTheWay = [...this.sent.values()].filter((message) => message.kind === kind);
    const free = onTheWay.every((message) => channel === "main" && message.channel === "main");
    if (!queue.size || !free || this.socket.readyState !== WebSocket.OPEN) return;
    const message = queue.get(channel);
    queue.delete(channel);
    this.sent.set(message.id, message);
    const { channel: _, ...request } = message;
    this.socket.send(JSON.stringify(request));
  }

  answered(answer) {
    const asked = this.sent.get(answer.id);
    for (const message of asked ? [...this.sent.values()] : []) {
      if (message.kind === asked.kind && message.id <= asked.id) this.sent.delete(message.id);
    }
    if (asked) this.next(asked.kind);
    this.receive(answer, asked);
  }
}
