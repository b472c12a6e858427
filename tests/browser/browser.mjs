// A Chromium without a window, driven through its debugging pipe: no package is needed for it.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const patience_ms = 300000;

/// WebGL on the processor: there is no display.
export const webgl = ["--enable-unsafe-swiftshader", "--use-angle=swiftshader"];
export const urlOf = file => pathToFileURL(resolve(file)).href;

/// What a canvas shows, as an expression for the page.
export const seenIn = canvas => `(() => {
    const copy = document.createElement("canvas");
    [copy.width, copy.height] = [64, 64];
    const context = copy.getContext("2d");
    context.drawImage(document.querySelector("${canvas}"), 0, 0, 64, 64);
    const { data } = context.getImageData(0, 0, 64, 64), halves = [0, 0];
    let sum = 0;
    for (let i = 0; i < data.length; i += 4) {
        halves[Number(i / 4 % 64 >= 32)] += (Math.abs(data[i] - 0x20) + Math.abs(data[i + 1] - 0x24) + Math.abs(data[i + 2] - 0x2a) > 12) / 2048;
        sum = (sum * 31 + data[i] + 256 * data[i + 1] + 65536 * data[i + 2]) % 1000000007;
    }
    return { part: (halves[0] + halves[1]) / 2, halves, sum };
})()`;

export class Browser {
    /// `more`: arguments of the program in addition to those that every test needs.
    constructor(program, more = []) {
        this.profile = mkdtempSync(join(tmpdir(), "fresco-chromium-"));
        // With file access, pages from files have an origin; without, Chromium 156 gives one load in fifty an empty storage.
        this.process = spawn(program, ["--headless=new", "--allow-file-access-from-files", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--remote-debugging-pipe",
            "--no-first-run", "--disable-background-networking", "--window-size=1280,800", `--user-data-dir=${this.profile}`, ...more],
            { stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"] });
        this.next = 1;
        this.waiting = new Map();
        this.problems = [];
        this.requests = [];
        this.downloads = [];
        this.loads = 0;
        this.rest = "";
        this.process.stdio[4].on("data", data => this.receive(data.toString()));
        this.ended = new Promise(resolve => this.process.on("exit", resolve));
        process.on("exit", () => {
            this.process.kill("SIGKILL");
            rmSync(this.profile, { recursive: true, force: true, maxRetries: 5 });
        });
    }

    receive(data) {
        const parts = (this.rest + data).split("\0");
        this.rest = parts.pop();
        for (const part of parts) {
            const message = JSON.parse(part);
            if (message.id) {
                const { resolve, reject } = this.waiting.get(message.id);
                this.waiting.delete(message.id);
                message.error ? reject(new Error(message.error.message)) : resolve(message.result);
            } else
                this.note(message);
        }
    }

    note({ method, params }) {
        if (method === "Runtime.exceptionThrown")
            this.problems.push(params.exceptionDetails.exception?.description ?? params.exceptionDetails.text);
        if (method === "Runtime.consoleAPICalled" && ["error", "warning", "assert"].includes(params.type))
            this.problems.push(params.args.map(argument => argument.value).join(" "));
        if (method === "Log.entryAdded" && params.entry.level !== "info")
            this.problems.push(params.entry.text);
        if (method === "Network.requestWillBeSent")
            this.requests.push(params.request.url);
        if (method === "Page.loadEventFired")
            ++this.loads;
        if (method === "Browser.downloadWillBegin")
            this.downloads.push({ guid: params.guid, name: params.suggestedFilename, state: "begun" });
        if (method === "Browser.downloadProgress")
            for (const download of this.downloads.filter(({ guid }) => guid === params.guid))
                download.state = params.state;
    }

    send(method, params = {}, session = this.session) {
        const id = this.next++;
        this.process.stdio[3].write(JSON.stringify({ id, method, params, sessionId: session }) + "\0");
        return new Promise((resolve, reject) => {
            const late = setTimeout(() => reject(new Error(`the browser does not answer to ${method} ${JSON.stringify(params)}`)), patience_ms);
            this.waiting.set(id, { resolve: result => { clearTimeout(late); resolve(result); }, reject: error => { clearTimeout(late); reject(error); } });
        });
    }

    /// Polls until `ready` gives something that is true.
    async wait(what, ready) {
        for (const end = Date.now() + patience_ms; Date.now() < end;) {
            const found = await ready();
            if (found)
                return found;
            await new Promise(resolve => setTimeout(resolve, 10));
        }
        throw new Error(`waited in vain for ${what}`);
    }

    async open(url = "about:blank", downloads = "/tmp") {
        const { targetId } = await this.send("Target.createTarget", { url: "about:blank" }, undefined);
        this.session = (await this.send("Target.attachToTarget", { targetId, flatten: true }, undefined)).sessionId;
        for (const domain of ["Page", "Runtime", "Log", "Network"])
            await this.send(`${domain}.enable`);
        await this.send("Browser.setDownloadBehavior", { behavior: "allow", downloadPath: downloads, eventsEnabled: true }, undefined);
        await this.load(url);
    }

    load(url) {
        return this.go(() => this.send("Page.navigate", { url }));
    }

    /// Waits for the page that `action` loads.
    async go(action) {
        const before = this.loads;
        await action();
        await this.wait("the page", () => this.loads > before);
    }

    async evaluate(expression) {
        const { result, exceptionDetails } = await this.send("Runtime.evaluate", { expression, returnByValue: true, awaitPromise: true });
        if (exceptionDetails)
            throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
        return result.value;
    }

    /// Waits until the expression is true in the page.
    async until(expression) {
        await this.wait(expression, () => this.evaluate(expression));
    }

    /// Waits for the next file that the page saves; gives the name that it proposes.
    async download() {
        const whole = await this.wait("a saved file", () => this.downloads.find(download => download.state === "completed" && !download.taken));
        whole.taken = true;
        return whole.name;
    }

    click(selector) {
        return this.evaluate(`document.querySelector(${JSON.stringify(selector)}).click()`);
    }

    text(selector) {
        return this.evaluate(`document.querySelector(${JSON.stringify(selector)}).textContent`);
    }

    mouse(type, x, y, more = {}) {
        return this.send("Input.dispatchMouseEvent", { type, x, y, button: "left", buttons: type === "mouseReleased" ? 0 : 1, clickCount: 1, ...more });
    }

    wheel(x, y, deltaY) {
        return this.mouse("mouseWheel", x, y, { button: "none", buttons: 0, deltaX: 0, deltaY });
    }

    async drag([x0, y0], [x1, y1]) {
        await this.mouse("mousePressed", x0, y0);
        for (const share of [0.3, 0.7, 1])
            await this.mouse("mouseMoved", x0 + share * (x1 - x0), y0 + share * (y1 - y0));
        await this.mouse("mouseReleased", x1, y1);
    }

    resize(width, height, mobile = false, deviceScaleFactor = 1) {
        return this.send("Emulation.setDeviceMetricsOverride", { width, height, deviceScaleFactor, mobile });
    }

    /// How much of the room's canvas is not the background, also of its halves, and a sum that changes with any point.
    seen(canvas = "#room canvas") {
        return this.evaluate(seenIn(canvas));
    }

    async press(key) {
        const text = key.length === 1 ? key : key === "Enter" ? "\r" : undefined;
        await this.send("Input.dispatchKeyEvent", { type: "keyDown", key, text, windowsVirtualKeyCode: key === "Enter" ? 13 : 0 });
        await this.send("Input.dispatchKeyEvent", { type: "keyUp", key });
    }

    /// Nothing complained, and nothing was fetched but the page. The driver remarks that reading the canvas back takes time.
    checkQuiet(url) {
        assert.deepEqual(this.problems.filter(problem => !problem.includes("GPU stall due to ReadPixels")), []);
        assert.deepEqual(this.requests.filter(request => request !== url && !/^(data|blob):/.test(request)), []);
    }

    async close() {
        await this.send("Browser.close", {}, undefined).catch(() => {});
        await this.ended;
    }
}
