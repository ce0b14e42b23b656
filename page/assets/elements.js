// Small tools for elements.

const SVG = "http://www.w3.org/2000/svg";

/** An element with attributes and children; text is text, never markup. */
export function element(name, attributes = {}, ...children) {
  return made(document.createElement(name), attributes, children);
}

/** The same in a drawing. */
export function drawn(name, attributes = {}, ...children) {
  return made(document.createElementNS(SVG, name), attributes, children);
}

function made(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else if (value === true) node.setAttribute(name, "");
    else if (value !== false && value !== undefined && value !== null) node.setAttribute(name, value);
  }
  node.append(...children);
  return node;
}

/** Sets an attribute only if it is another one: a browser lays out less. */
export function set(node, name, value) {
  const text = String(value);
  if (node.getAttribute(name) !== text) node.setAttribute(name, text);
}

/** Sets a text only if it is another one. */
export function say(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

/** Makes a list show one row for each item, keeping the rows that are there. */
export function rows(list, items, key, make, update) {
  const known = list.rowsByKey ?? (list.rowsByKey = new Map());
  const next = new Map();
  let before = null;
  for (const item of items) {
    const name = key(item);
    if (next.has(name)) continue;
    const row = known.get(name) ?? make(item);
    update(row, item);
    next.set(name, row);
    const place = before ? before.nextSibling : list.firstChild;
    if (place !== row) list.insertBefore(row, place);
    before = row;
  }
  for (const [name, row] of known) if (!next.has(name)) row.remove();
  list.rowsByKey = next;
}
