// Elements of the page. Whatever comes from a run is set as text or as an attribute, never as markup.

function fill(node, attributes, children) {
    for (const [name, value] of Object.entries(attributes))
        if (name.startsWith("on"))
            node.addEventListener(name.slice(2), value);
        else if (value !== undefined && value !== false)
            node.setAttribute(name, value === true ? "" : value);
    node.append(...children.flat(Infinity).filter(child => child !== null && child !== undefined && child !== ""));
    return node;
}

/// element("p", { class: "soft", onclick: act }, "text", node, [nodes]); children that are null or empty are left out.
const element = (name, attributes = {}, ...children) => fill(document.createElement(name), attributes, children);
const svg = (name, attributes = {}, ...children) => fill(document.createElementNS("http://www.w3.org/2000/svg", name), attributes, children);

const section = (title, ...children) => element("section", {}, element("h2", {}, title), ...children);
const scrolled = (...children) => element("div", { class: "scroll", tabindex: 0 }, ...children);

/// A table of texts and nodes; numbers are drawn as figures, to the right.
function tableOf(columns, rows) {
    const cell = (name, value) => element(name, { class: typeof value === "number" && "number" }, typeof value === "number" ? figureText(value) : value);
    return scrolled(element("table", {},
        element("thead", {}, element("tr", {}, columns.map(column => cell("th", column)))),
        element("tbody", {}, rows.map(row => element("tr", {}, row.map(value => cell("td", value)))))));
}

/// Pairs of a term and what it comes to: [[term, text or nodes], …].
const definitions = pairs => element("dl", {}, pairs.map(([term, ...parts]) => element("div", {}, element("dt", {}, term), element("dd", {}, ...parts))));

const link = (path, ...children) => element("a", { href: addressOf(path) }, ...children);
