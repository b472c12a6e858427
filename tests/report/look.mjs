// look.mjs CHROMIUM REPORT.html [SHOTS]: the page as somebody sees it who opens it: the room is drawn and turns, the slider moves, nothing is
// fetched, no complaints. With a folder for it, pictures of the page.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { dirname, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Browser } from "../browser/browser.mjs";
import { checkPage } from "./pages.mjs";

const [program, page, shots] = process.argv.slice(2);
const url = pathToFileURL(resolve(page)).href;
// WebGL on the processor: there is no display.
const browser = new Browser(program, ["--enable-unsafe-swiftshader", "--use-angle=swiftshader"]);
await browser.open(url, "/tmp");

/// The canvas as it is shown: how many of its points are not the background, and a sum that changes with any of them.
const seen = () => browser.evaluate(`(() => {
    const canvas = document.querySelector("#room canvas");
    const copy = document.createElement("canvas");
    [copy.width, copy.height] = [64, 48];
    const context = copy.getContext("2d");
    context.drawImage(canvas, 0, 0, 64, 48);
    const { data } = context.getImageData(0, 0, 64, 48);
    let shown = 0, sum = 0;
    for (let i = 0; i < data.length; i += 4) {
        shown += Math.abs(data[i] - 0x20) + Math.abs(data[i + 1] - 0x24) + Math.abs(data[i + 2] - 0x2a) > 12;
        sum = (sum * 31 + data[i] + 256 * data[i + 1] + 65536 * data[i + 2]) % 1000000007;
    }
    return { shown: shown / (64 * 48), sum };
})()`);
const boxOf = selector => browser.evaluate(`(({x, y, width, height}) => ({x, y, width, height}))(document.querySelector(${JSON.stringify(selector)}).getBoundingClientRect())`);
const click = selector => browser.evaluate(`document.querySelector(${JSON.stringify(selector)}).click()`);
async function drag(from, to) {
    const event = (type, { x, y }) => browser.send("Input.dispatchMouseEvent", { type, x, y, button: "left", buttons: type === "mouseReleased" ? 0 : 1, clickCount: 1 });
    await event("mousePressed", from);
    for (const share of [0.3, 0.7, 1])
        await event("mouseMoved", { x: from.x + share * (to.x - from.x), y: from.y + share * (to.y - from.y) });
    await event("mouseReleased", to);
}

await browser.until(`document.getElementById("room").dataset.ready === "yes"`);
await browser.evaluate(`document.getElementById("room").scrollIntoView({ block: "center" })`);
const inside = await seen();
assert(inside.shown > 0.6, `the room fills ${inside.shown} of the canvas`);
const box = await boxOf("#room canvas");
const middle = { x: box.x + box.width / 2, y: box.y + box.height / 2 };
await drag(middle, { x: middle.x + 180, y: middle.y });
const turned = await seen();
assert.notEqual(turned.sum, inside.sum, "dragging does not turn the room");
await browser.send("Input.dispatchMouseEvent", { type: "mouseWheel", x: middle.x, y: middle.y, deltaX: 0, deltaY: 300 });
const farther = await seen();
assert.notEqual(farther.sum, turned.sum, "the wheel does not move");
await click("#outside");
const outside = await seen();
assert(outside.shown > 0.05 && outside.shown < 0.95, `from outside the room fills ${outside.shown} of the canvas`);
if (shots) {
    const { data } = await browser.send("Page.captureScreenshot");
    writeFileSync(`${shots}/outside.png`, Buffer.from(data, "base64"));
}
await click("#inside");
assert.equal((await seen()).sum, inside.sum, "the way back inside leads elsewhere");

// The shares of the mixture: the room follows, and the line for the pipeline.
const share = (name, value) => browser.evaluate(`(() => {
    const input = document.getElementById("mix-${name}");
    input.value = ${value};
    input.dispatchEvent(new Event("input"));
})()`);
const looks = new Set([(await seen()).sum]);
for (const [name, value] of [["color", 0], ["strokes", 0], ["color", 1], ["strokes", 1]]) {
    await share(name, value);
    looks.add((await seen()).sum);
}
assert.equal(looks.size, 5, "a share changes nothing");
assert.equal(await browser.evaluate(`document.getElementById("shares").textContent`), "mixed: {color: 1, strokes: 1}");
await share("color", 0.5);
assert.equal((await seen()).sum, inside.sum, "the room does not come back with its shares");

// The slider, by mouse and by keyboard; another view by its thumbnail.
await browser.evaluate(`document.querySelector(".compare").scrollIntoView({ block: "center" })`);
const cut = () => browser.evaluate(`parseFloat(getComputedStyle(document.querySelector(".compare .over")).clipPath.match(/[\\d.]+%\\)/)[0])`);
const slider = await boxOf(".compare input");
const at = share => ({ x: slider.x + share * slider.width, y: slider.y + slider.height / 2 });
assert.equal(await cut(), 50);
await drag(at(0.5), at(0.2));
const left = await cut();
assert(Math.abs(left - 20) < 3, `the picture is cut at ${left} %`);
await browser.evaluate(`document.querySelector(".compare input").focus()`);
await browser.press("End");
await browser.send("Input.dispatchKeyEvent", { type: "keyDown", key: "End", windowsVirtualKeyCode: 35 });
assert.equal(await cut(), 100);
const views = await browser.evaluate(`document.querySelectorAll(".thumbs button").length`);
assert(views >= 2 && views <= 12, `${views} views`);
const first = await browser.evaluate(`document.querySelector(".compare img").src.length + document.getElementById("view-name").textContent`);
await click(".thumbs button:last-child");
assert.notEqual(await browser.evaluate(`document.querySelector(".compare img").src.length + document.getElementById("view-name").textContent`), first);
await click("#stand-here");
assert.notEqual((await seen()).sum, inside.sum, "the last view's place is the first one's");

// What the run began with, and how. What it said stays text.
const text = selector => browser.evaluate(`document.querySelector(${JSON.stringify(selector)}).textContent`);
assert.deepEqual(await browser.evaluate(`Array.from(document.querySelectorAll(".given figcaption")).map(each => each.textContent)`), ["style: picture.npy", "style: demo.jpg"]);
assert.match(await text("pre.command"), /fresco run .*room\.yaml --store .* --cores 2$/);
assert.equal(await browser.evaluate(`document.getElementById("evil")`), null);
assert((await text("main")).includes("</script><b id=evil>"));
assert.deepEqual(JSON.parse(await text("#data")), JSON.parse(readFileSync(`${dirname(page)}/run.json`, "utf8")));
for (const title of ["The pipeline", "The room", "Camera and render", "The atlas", "Frames kept and dropped", "Stages", "Files", "How it was made"])
    assert(await browser.evaluate(`Array.from(document.querySelectorAll("h2")).some(each => each.textContent === ${JSON.stringify(title)})`), `no "${title}"`);
await checkPage(browser, url, "run", shots);

// Without scripts it says where the data are.
await browser.send("Emulation.setScriptExecutionDisabled", { value: true });
await browser.go(() => browser.send("Page.navigate", { url }));
assert((await browser.evaluate("document.body.innerText")).includes("run.json"));
await browser.close();
console.log(`the room fills ${inside.shown.toFixed(2)} of its canvas, ${views} views`);
