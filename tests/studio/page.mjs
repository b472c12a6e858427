// The page of fresco studio in a browser, for its tests.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { mkdtempSync, readFileSync, writeFileSync } from "node:fs";
import { basename, join } from "node:path";
import { Browser, webgl } from "../browser/browser.mjs";

const watched = browser => browser.evaluate(`(() => { const box = document.getElementById("problem"); return box.hidden ? "" : box.textContent; })()`);

/// Waits for what is expected; an error in the page ends it at once.
export async function until(browser, expression) {
    await browser.wait(expression, async () => {
        const problem = await watched(browser);
        assert.equal(problem, "", `while waiting for ${expression}`);
        return browser.evaluate(expression);
    });
}

export const has = (browser, text) => until(browser, `document.getElementById("badge").textContent === ${JSON.stringify(text)}`);
export const ready = (browser, what) => until(browser, `document.getElementById("status").textContent.startsWith(${JSON.stringify(`${what} ready`)})`);

/// Drops a file onto the page, as a hand would.
export async function drop(browser, file) {
    const text = readFileSync(file).toString("base64");
    await browser.evaluate(`(() => {
        const bytes = Uint8Array.from(atob("${text}"), letter => letter.charCodeAt(0));
        const data = new DataTransfer();
        data.items.add(new File([bytes], ${JSON.stringify(basename(file))}));
        for (const type of ["dragenter", "dragover", "drop"])
            document.body.dispatchEvent(new DragEvent(type, { bubbles: true, cancelable: true, dataTransfer: data }));
    })()`);
}

export const setting = (browser, name, value) => browser.evaluate(`(() => {
    const input = document.getElementById("set-${name.replace(".", "-")}");
    input.value = "${value}";
    input.dispatchEvent(new Event("change"));
})()`);

/// What is started and opened for one folder: {saved, served, opened, shoot}; the browser saves files in `saved`.
export function studioIn(folder, program, fresco, screenshots) {
    const saved = mkdtempSync(join(folder, "../saved-"));

    /// Starts the server; gives {process, address}.
    async function served(place = folder, ...words) {
        const started = spawn(fresco, ["studio", place, "--no-browser", ...words], { stdio: ["ignore", "pipe", "inherit"] });
        process.on("exit", () => started.kill("SIGKILL"));
        const address = await new Promise((resolve, reject) => {
            started.stdout.on("data", data => resolve(data.toString().trim()));
            started.on("exit", code => reject(new Error(`fresco studio ended with ${code}`)));
        });
        return { process: started, address, ended: new Promise(resolve => started.on("exit", resolve)) };
    }

    async function opened(address) {
        const browser = new Browser(program, webgl);
        await browser.open(address, saved);
        await browser.resize(1280, 800);
        await browser.until(`document.getElementById("folder").textContent !== ""`);
        return browser;
    }

    async function shoot(browser, name) {
        if (!screenshots)
            return;
        for (const scheme of ["light", "dark"])
            for (const [width, height] of [[1280, 800], [1920, 1080]]) {
                await browser.send("Emulation.setEmulatedMedia", { features: [{ name: "prefers-color-scheme", value: scheme }] });
                await browser.resize(width, height);
                await browser.evaluate("new Promise(done => setTimeout(done, 400))");
                const { data } = await browser.send("Page.captureScreenshot");
                writeFileSync(join(screenshots, `${name}_${width}_${scheme}.png`), Buffer.from(data, "base64"));
            }
        await browser.resize(1280, 800);
    }

    return { saved, served, opened, shoot };
}
