// Storage of the browser. A frame within a page of another site, as in a notebook, may have none: then it lasts as
// long as the page.

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
