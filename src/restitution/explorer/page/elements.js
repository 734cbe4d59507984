// Elements of the page, the words in them, and the storage of the browser.
export function element(name, properties = {}, ...children) {
  const node = Object.assign(document.createElement(name), properties);
  node.append(...children);
  return node;
}

export const sentence = (words) => words.charAt(0).toUpperCase() + words.slice(1);

// A button with what it does.
export function button(words, act, properties = {}) {
  const node = element("button", { type: "button", ...properties }, words);
  node.addEventListener("click", act);
  return node;
}

// A frame within a page of another site, as in a notebook, may have no storage: then it lasts as long as the page.
function storage(name) {
  try {
    return window[name];
  } catch {
    const kept = new Map();
    return { getItem: (key) => kept.get(key) ?? null, setItem: (key, value) => kept.set(key, String(value)) };
  }
}

export const ofTab = storage("sessionStorage");
export const ofBrowser = storage("localStorage");
