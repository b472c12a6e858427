// participate.mjs CHROMIUM STUDY.html KEY.json RESULTS: three people take part, by keyboard; each prefers alpha where the first question is
// asked and cannot decide where the second is. The second is interrupted, and the third ends early.
import assert from "node:assert/strict";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { Browser, urlOf } from "../browser/browser.mjs";

const [program, page, keyFile, results] = process.argv.slice(2);
mkdirSync(results);
const key = JSON.parse(readFileSync(keyFile));
assert(!/alpha|beta/.test(readFileSync(page, "utf8")), "the page names a method");
const browser = new Browser(program);
const ready = count => browser.until(`ready && document.getElementById("count").textContent === "${count} of 8"`);

const begin = code => browser.evaluate(`document.getElementById("participant").value = "${code}"; document.querySelector("#start button").click()`);

async function decide() {
    const pictures = await browser.evaluate(`["left", "right"].map(side => study.pictures.indexOf(document.getElementById(side).src))`);
    const [left, right] = pictures.map(number => key.pictures[number]);
    assert(left.name === right.name && left.method !== right.method);
    const first = await browser.evaluate(`document.getElementById("question").textContent`) === key.questions[0];
    await browser.press(!first ? "ArrowDown" : left.method === "alpha" ? "ArrowLeft" : "ArrowRight");
    return `${left.name} ${first}`;
}

await browser.open(urlOf(page), results);
for (const code of ["one", "two", "three"]) {
    await begin(code);
    const seen = [];
    for (let count = 1; count <= (code === "three" ? 3 : 8); ++count) {
        await ready(count);
        if (code === "two" && count === 4) {
            await browser.go(() => browser.send("Page.reload"));
            await begin("two");
            await ready(4);
            await browser.press("Backspace").then(() => ready(3));
            assert.equal(await decide(), seen[2], "another pair after a way back");
            await ready(4);
        }
        seen.push(await decide());
    }
    assert.equal(new Set(seen).size, seen.length, "a pair was shown twice with one question");
    if (code === "three")
        await ready(4).then(() => browser.click("#stop"));
    await browser.until(`!document.getElementById("end").hidden`);
    writeFileSync(`${results}/${code}.json`, await browser.evaluate(`document.getElementById("text").value`));
    await browser.click("#another");
}
browser.checkQuiet(urlOf(page));
await browser.close();
