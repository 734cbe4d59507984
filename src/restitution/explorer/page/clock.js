// The time of the animation: flight, contact in slow motion, flight back. All pictures follow it.
import { button, element } from "./elements.js";
import { calm } from "./theme.js";

const DURATION = 6500;
const PAUSE = 20;
const FALL = 0.2;
const REBOUND = 0.8;

const clamped = (share) => Math.min(Math.max(share, 0), 1);

export class Clock {
  constructor() {
    Object.assign(this, { share: 0.46, length: 1, playing: false, listeners: [] });
  }

  onTick(listener) {
    this.listeners.push(listener);
  }

  // The contact lasts `length` seconds.
  span(length) {
    this.length = length;
    this.notify();
  }

  // Time since first touch over the contact time: below 0 in the fall, above 1 after separation.
  get phase() {
    if (this.share < FALL) return (this.share - FALL) / FALL;
    if (this.share <= REBOUND) return (this.share - FALL) / (REBOUND - FALL);
    return 1 + (this.share - REBOUND) / (1 - REBOUND);
  }

  get time() {
    return clamped(this.phase) * this.length;
  }

  // How much slower than reality the contact is.
  get slowness() {
    return (DURATION / 1000) * (REBOUND - FALL) / this.length;
  }

  toTime(time) {
    this.to(FALL + (REBOUND - FALL) * clamped(time / this.length));
  }

  to(share) {
    this.playing = false;
    this.share = clamped(share);
    this.notify();
  }

  play() {
    if (this.playing) return;
    this.playing = true;
    let before = performance.now();
    const run = this.run = {};
    const step = (now) => {
      if (!this.playing || this.run !== run) return;
      this.share = (this.share + Math.min(now - before, 100) / DURATION) % 1;
      before = now;
      this.notify();
      // At twice as many pictures a second an answer waits for the next one.
      setTimeout(() => requestAnimationFrame(step), PAUSE);
    };
    requestAnimationFrame(step);
    this.notify();
  }

  start() {
    if (calm()) this.notify();
    else this.play();
  }

  notify() {
    for (const listener of this.listeners) listener(this);
  }
}

// Its button and its slider.
export function timeControl(clock) {
  const play = button("Play", () => (clock.playing ? clock.to(clock.share) : clock.play()), { className: "play" });
  const slider = element("input", { type: "range", min: 0, max: 1000, step: 5, ariaLabel: "Time of the slow motion" });
  slider.addEventListener("input", () => clock.to(slider.value / 1000));
  clock.onTick(() => {
    const words = clock.playing ? "Pause" : "Play";
    if (play.textContent !== words) play.textContent = words;
    slider.value = 1000 * clock.share;
    slider.style.setProperty("--share", `${100 * clock.share}%`);
    const { phase } = clock;
    slider.setAttribute("aria-valuetext", phase < 0 ? "fall" : phase > 1 ? "flight back" : `${Math.round(100 * phase)} % of the contact`);
  });
  return element("div", { className: "player" }, play, slider);
}
