// look_at_sweep.mjs CHROMIUM SWEEP.html [SHOTS]: the page of a matrix: pictures of each combination, and the figures in which they differ.
import assert from "node:assert/strict";
import { Browser, urlOf } from "../browser/browser.mjs";
import { checkPage } from "./pages.mjs";

const [program, page, shots] = process.argv.slice(2);
const browser = new Browser(program);
await browser.open(urlOf(page));
const cells = await browser.evaluate(`Array.from(document.querySelectorAll(".cards article")).map(cell => [cell.querySelector("h3").textContent, cell.querySelectorAll("img").length, cell.querySelector(".badge").textContent, cell.querySelector("a[href$='report.html']").getAttribute("href")])`);
assert.deepEqual(cells, [256, 512].map(size => [`size=${size}`, 3, "done", `./size%3D${size}/report.html`]));
assert(await browser.evaluate(`Array.from(document.images).every(image => image.src.startsWith("data:image/jpeg"))`));
const stages = await browser.evaluate(`Array.from(document.querySelectorAll("details summary")).map(each => each.textContent)`);
assert(stages.includes("texture") && !stages.includes("scan"), `figures of ${stages}`);
await checkPage(browser, urlOf(page), "sweep", shots);
await browser.close();
console.log(`the sweep's page shows ${cells.length} combinations`);
