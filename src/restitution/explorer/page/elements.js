// Elements of the page, and the words in them.
export function element(name, properties = {}, ...children) {
  const node = Object.assign(document.createElement(name), properties);
  node.append(...children);
  return node;
}

export const sentence = (words) => words.charAt(0).toUpperCase() + words.slice(1);
