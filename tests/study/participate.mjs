// participate.mjs CHROMIUM STUDY.html KEY.json DOWNLOADS: three people take part, by keyboard, as a person would; each of them prefers
// alpha where the first question is asked and cannot decide where the second is.
import assert from "node:assert/strict";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Browser } from "../browser/browser.mjs";

const [program, page, keyFile, downloads] = process.argv.slice(2);
mkdirSync(downloads, { recursive: true });
const key = JSON.parse(readFileSync(keyFile));
const html = readFileSync(page, "utf8");
for (const method of ["alpha", "beta"])
    assert(!html.includes(method), `the page names ${method}`);
const url = pathToFileURL(resolve(page)).href;
const browser = new Browser(program);

const state = () => browser.evaluate(`({
    count: document.getElementById("count").textContent, question: document.getElementById("question").textContent,
    left: document.getElementById("left").src, right: document.getElementById("right").src })`);
const ready = count => browser.until(`document.getElementById("count").textContent === "${count} of 8" &&
    !document.querySelector("#choices button").disabled && !document.getElementById("trial").hidden`);

/// Exactly this part of the page is to be seen.
async function sees(part) {
    const seen = await browser.evaluate(`Array.from(document.querySelectorAll("section")).filter(section => section.getClientRects().length > 0).map(section => section.id)`);
    assert.deepEqual(seen, [part]);
}

async function begin(code) {
    await sees("welcome");
    await browser.evaluate(`document.getElementById("participant").focus(); document.getElementById("participant").select()`);
    await browser.send("Input.insertText", { text: code });
    await browser.press("Enter");
}

/// What the person sees, found in the key by the pictures' numbers.
async function look() {
    await sees("trial");
    const seen = await state();
    const pictures = await browser.evaluate(`JSON.parse(document.getElementById("study-data").textContent).pictures`);
    const [left, right] = [seen.left, seen.right].map(uri => key.pictures[pictures.indexOf(uri)]);
    assert.equal(left.name, right.name);
    assert.notEqual(left.method, right.method);
    return { ...seen, left, right };
}

async function decide() {
    const seen = await look();
    const first = seen.question === key.questions[0];
    const choice = !first ? "ArrowDown" : seen.left.method === "alpha" ? "ArrowLeft" : "ArrowRight";
    await browser.press(choice);
    return seen;
}

async function save(code) {
    await browser.until(`!document.getElementById("end").hidden`);
    await sees("end");
    await browser.press("Enter");  // The link has the focus.
    assert.equal(await browser.download(), `study-${key.study.slice(0, 8)}-${code}.json`);
    return browser.evaluate(`document.getElementById("text").value`);
}

await browser.open(url, downloads);
const orders = [];
const sides = new Map();  // Of each view: the methods that were on the left.
for (const code of ["one", "two", "three"]) {
    await begin(code);
    const order = [];
    for (let count = 1; count <= 8; ++count) {
        await ready(count);
        if (code === "two" && count === 4) {
            // Interrupted: the page is closed, and goes on where it was.
            await browser.go(() => browser.send("Page.reload"));
            assert.equal(await browser.evaluate(`document.getElementById("participant").value`), "two");
            assert.match(await browser.evaluate(`document.getElementById("saved").textContent`), /3 of 8 answers/);
            await begin("two");
            await ready(4);
        }
        if (code === "one" && count === 3) {
            // Back, and the same pair is there again.
            const third = await look();
            await browser.press("Backspace");
            await ready(2);
            await decide();
            await ready(3);
            assert.deepEqual(await look(), third);
        }
        const seen = await decide();
        order.push(seen.left.name + seen.question);
        sides.set(seen.left.name, (sides.get(seen.left.name) ?? new Set()).add(seen.left.method));
    }
    assert.equal(new Set(order).size, 8, "a pair was shown twice with one question");
    orders.push(order.join());
    writeFileSync(`${downloads}/${code}.text`, await save(code));
    await browser.evaluate(`document.getElementById("another").click()`);
}
assert.equal(new Set(orders).size, 3, "two participants saw the same order");
assert(Array.from(sides.values()).some(methods => methods.size === 2), "a pair's sides never change");

// Looking closer moves both pictures alike; another key does not answer.
await begin("four");
await ready(1);
const box = await browser.evaluate(`(({x, y, width, height}) => ({x, y, width, height}))(document.querySelector(".frame").getBoundingClientRect())`);
const transforms = () => browser.evaluate(`["left", "right"].map(id => document.getElementById(id).parentElement.style.transform)`);
// The hint lies where it should on the picture, which keeps its shape in the frame.
const hint = await browser.evaluate(`(() => {
    const [frame, rect] = ["#left", "#left-hints rect"].map(name => document.querySelector(name).getBoundingClientRect());
    const scale = Math.min(frame.width / 160, frame.height / 120);
    return [rect.left - (frame.left + frame.width / 2 - 40 * scale), rect.top - (frame.top + frame.height / 2), rect.width - 80 * scale,
            rect.height - 30 * scale];
})()`);
assert(hint.every(error => Math.abs(error) < 4), String(hint));
const [x, y] = [box.x + box.width * 0.75, box.y + box.height / 2];
await browser.send("Input.dispatchMouseEvent", { type: "mouseWheel", x, y, deltaX: 0, deltaY: -400 });
await browser.until(`!document.getElementById("right").parentElement.style.transform.endsWith("scale(1)")`);
const [one, other] = await transforms();
assert.equal(one, other);
const scale = Math.exp(1);
const [, shift, , drawn] = one.match(/translate\((-?[\d.]+)%, (-?[\d.]+)%\) scale\(([\d.]+)\)/);
assert(Math.abs(drawn - scale) < 1e-3, one);
assert(Math.abs(shift - 75 * (1 - scale)) < 0.5, one);  // The point below the mouse stays where it is.
await browser.press("q");
assert.equal((await state()).count, "1 of 8");
for (const type of ["mousePressed", "mouseReleased"])
    await browser.send("Input.dispatchMouseEvent", { type, x, y, button: "left", clickCount: 1 });
await browser.until(`document.getElementById("left").parentElement.style.transform.endsWith("scale(1)")`);
// Finished early: what is there counts.
await browser.press("n");
await ready(2);
await browser.evaluate(`document.getElementById("stop").click()`);
const early = JSON.parse(await browser.evaluate(`document.getElementById("text").value`));
assert.equal(early.complete, false);
assert.equal(early.answers.length, 1);

// A browser that forbids storage: one sitting, without complaints.
await browser.send("Page.addScriptToEvaluateOnNewDocument", { source: `Object.defineProperty(window, "localStorage", { get() { throw new DOMException("forbidden", "SecurityError"); } });` });
await browser.go(() => browser.send("Page.reload"));
await begin("five");
await ready(1);
await browser.press("b");
await ready(2);

// For a look at it: FRESCO_STUDY_SHOTS=FOLDER.
if (process.env.FRESCO_STUDY_SHOTS)
    for (const [name, width, height, mobile] of [["wide", 1280, 800, false], ["phone", 390, 800, true]]) {
        await browser.send("Emulation.setDeviceMetricsOverride", { width, height, deviceScaleFactor: 1, mobile });
        const { data } = await browser.send("Page.captureScreenshot");
        writeFileSync(`${process.env.FRESCO_STUDY_SHOTS}/${name}.png`, Buffer.from(data, "base64"));
    }

assert.deepEqual(browser.problems, []);
assert.deepEqual(browser.requests.filter(request => request !== url && !request.startsWith("data:") && !request.startsWith("blob:")), []);
await browser.close();
console.log("three participants answered 8 questions each");
