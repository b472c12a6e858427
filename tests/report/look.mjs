// look.mjs CHROMIUM REPORT.html SWEEP.html: the page of a run as somebody sees it who opens it: the room is drawn and turns, the slider
// moves, nothing is fetched, no complaints.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { dirname } from "node:path";
import { Browser, urlOf, webgl } from "../browser/browser.mjs";
import { checkPage } from "./pages.mjs";

const [program, page, sweep] = process.argv.slice(2);
const browser = new Browser(program, webgl);
await browser.open(urlOf(page));

const boxOf = selector => browser.evaluate(`(({x, y, width, height}) => ({x, y, width, height}))(document.querySelector(${JSON.stringify(selector)}).getBoundingClientRect())`);
await browser.until(`document.getElementById("room").dataset.ready === "yes"`);
await browser.evaluate(`document.getElementById("room").scrollIntoView({ block: "center" })`);
const inside = await browser.seen();
assert(inside.part > 0.6, `the room fills ${inside.part} of the canvas`);
const box = await boxOf("#room canvas");
const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
await browser.drag([x, y], [x + 180, y]);
const turned = await browser.seen();
assert.notEqual(turned.sum, inside.sum, "dragging does not turn the room");
await browser.wheel(x, y, 300);
const farther = await browser.seen();
assert.notEqual(farther.sum, turned.sum, "the wheel does not move");
await browser.click("#outside");
const outside = await browser.seen();
assert(outside.part > 0.05 && outside.part < 0.95, `from outside the room fills ${outside.part} of the canvas`);
await browser.click("#inside");
assert.equal((await browser.seen()).sum, inside.sum, "the way back inside leads elsewhere");

// The shares of the mixture: the room follows, and the line for the pipeline.
const share = (name, value) => browser.evaluate(`(() => {
    const input = document.getElementById("mix-${name}");
    input.value = ${value};
    input.dispatchEvent(new Event("input"));
})()`);
const looks = new Set([(await browser.seen()).sum]);
for (const [name, value] of [["color", 0], ["strokes", 0], ["color", 1], ["strokes", 1]]) {
    await share(name, value);
    looks.add((await browser.seen()).sum);
}
assert.equal(looks.size, 5, "a share changes nothing");
assert.equal(await browser.evaluate(`document.getElementById("shares").textContent`), "mixed: {color: 1, strokes: 1}");
await share("color", 0.5);
assert.equal((await browser.seen()).sum, inside.sum, "the room does not come back with its shares");

// The slider, by mouse and by keyboard; another view by its thumbnail.
await browser.evaluate(`document.querySelector(".compare").scrollIntoView({ block: "center" })`);
const cut = () => browser.evaluate(`parseFloat(getComputedStyle(document.querySelector(".compare .over")).clipPath.match(/[\\d.]+%\\)/)[0])`);
const slider = await boxOf(".compare input");
const at = share => [slider.x + share * slider.width, slider.y + slider.height / 2];
assert.equal(await cut(), 50);
await browser.drag(at(0.5), at(0.2));
const left = await cut();
assert(Math.abs(left - 20) < 3, `the picture is cut at ${left} %`);
await browser.evaluate(`document.querySelector(".compare input").focus()`);
await browser.press("End");
await browser.send("Input.dispatchKeyEvent", { type: "keyDown", key: "End", windowsVirtualKeyCode: 35 });
assert.equal(await cut(), 100);
const views = await browser.evaluate(`document.querySelectorAll(".thumbs button").length`);
assert(views >= 2 && views <= 12, `${views} views`);
const shown = () => browser.evaluate(`document.querySelector(".compare img").src.length + document.getElementById("view-name").textContent`);
const first = await shown();
await browser.click(".thumbs button:last-child");
assert.notEqual(await shown(), first);
await browser.click("#stand-here");
assert.notEqual((await browser.seen()).sum, inside.sum, "the last view's place is the first one's");

// What the run began with, and how. What it said stays text.
assert.deepEqual(await browser.evaluate(`Array.from(document.querySelectorAll(".given figcaption")).map(each => each.textContent)`), ["style: picture.npy", "style: demo.jpg"]);
assert.match(await browser.text("pre.command"), /fresco run .*room\.yaml --store .* --cores 2$/);
assert.equal(await browser.evaluate(`document.getElementById("evil")`), null);
assert((await browser.text("main")).includes("</script><b id=evil>"));
assert.deepEqual(JSON.parse(await browser.text("#data")), JSON.parse(readFileSync(`${dirname(page)}/run.json`, "utf8")));
for (const title of ["The pipeline", "The room", "Camera and render", "The atlas", "Frames kept and dropped", "Stages", "Files", "How it was made"])
    assert(await browser.evaluate(`Array.from(document.querySelectorAll("h2")).some(each => each.textContent === ${JSON.stringify(title)})`), `no "${title}"`);
await checkPage(browser, urlOf(page));

// Without scripts it says where the data are.
await browser.send("Emulation.setScriptExecutionDisabled", { value: true });
await browser.load(urlOf(page));
assert((await browser.evaluate("document.body.innerText")).includes("run.json"));
await browser.close();
console.log(`the room fills ${inside.part.toFixed(2)} of its canvas, ${views} views`);

// The page of a matrix: pictures of each combination, and the figures in which they differ.
const other = new Browser(program);
await other.open(urlOf(sweep));
const cells = await other.evaluate(`Array.from(document.querySelectorAll(".cards article")).map(cell => [cell.querySelector("h3").textContent, cell.querySelectorAll("img").length, cell.querySelector(".badge").textContent, cell.querySelector("a[href$='report.html']").getAttribute("href")])`);
assert.deepEqual(cells, [256, 512].map(size => [`size=${size}`, 3, "done", `./size%3D${size}/report.html`]));
assert(await other.evaluate(`Array.from(document.images).every(image => image.src.startsWith("data:image/jpeg"))`));
const stages = await other.evaluate(`Array.from(document.querySelectorAll("details summary")).map(each => each.textContent)`);
assert(stages.includes("texture") && !stages.includes("scan"), `figures of ${stages}`);
await checkPage(other, urlOf(sweep));
await other.close();
console.log(`the sweep's page shows ${cells.length} combinations`);
