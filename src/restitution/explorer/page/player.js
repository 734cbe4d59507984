// Buttons and slider of the animation.
import { element } from "./inputs.js";

export function timeControl(clock) {
  const play = element("button", { type: "button", className: "play" });
  const slider = element("input", { type: "range", min: 0, max: 1000, step: 5 });
  slider.setAttribute("aria-label", "Time of the slow motion");
  play.addEventListener("click", () => {
    if (clock.playing) clock.pause();
    else clock.play();
    clock.notify();
  });
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
