// The page: what is chosen, what runs, what is shown. All that it does, it asks of the server, which runs `fresco run`.

const at = id => document.getElementById(id);
const poll_ms = 500;

async function ask(path, body) {
    const response = await fetch(path, body === undefined ? {} : { method: "POST", body: JSON.stringify(body) });
    const answer = await response.json();
    if (!response.ok)
        throw new Error(answer.error);
    return answer;
}

async function bytesAt(path, gone = `${path} is not there`) {
    const response = await fetch(path);
    if (!response.ok)
        throw new Error(gone);
    return response.arrayBuffer();
}

const chosen = { scan: null, picture: null, settings: {} };
const past = [];  // What was chosen before, for undo.
const versions = new Map();  // Of thumbnails, so that a new one is fetched.
let folder = { scans: [], pictures: [], runs: [], shipped: [] };
let paintings = [], running = null, watched = null, seen_serial = 0, shown = null, shown_scan = null, settings = null;
let lack = "The studio is looking for StyleMesh's weights.";  // Why StyleMesh cannot be chosen.
let later = false;  // Something was changed during a painting: its preview follows.
const view = new View(at("room"));
const thumbnails = new Thumbnails((name, src) => [...at("scans").querySelectorAll("button")].find(each => each.dataset.name === name)?.firstChild.replaceWith(element("img", { src, alt: "" })));

const isBusy = () => running?.care === "full";

function say(text) {
    at("status").textContent = text;
}

function complain(text) {
    at("problem").hidden = !text;
    at("problem").textContent = text ?? "";
}

/// Errors of requests go where those of runs go.
function guarded(action) {
    return (...words) => Promise.resolve(action(...words)).catch(error => complain(error.message));
}

// Runs and their events.

/// Follows the events of one run until it ends. `log`: their address; `out`: where its results are.
class Watch {
    constructor(log, out, care) {
        Object.assign(this, { log, out, care });
        this.reset();
    }

    reset() {
        Object.assign(this, { from: 0, tag: null, stages: new Map(), files: new Set(), problems: [], warnings: [], newest: null, grown_at: 0, pause_ms: 1500, note: "", end: null, over: false, is_killed: false, is_shown: false });
        this.zero = this.heard_at = performance.now() / 1000;  // When the run began, as far as its events tell.
    }

    /// Seconds since the run began.
    get clock_s() {
        return performance.now() / 1000 - this.zero;
    }

    async poll() {
        const response = await fetch(`${this.log}?optional&from=${this.from}`);
        if (response.status !== 200)
            return;
        const [, is_open, tag] = response.headers.get("etag").match(/^(W\/)?(.*)$/);
        if (this.tag && tag !== this.tag)
            return this.reset();  // Another run has taken its place.
        this.tag = tag;
        const bytes = new Uint8Array(await response.arrayBuffer());
        const end = bytes.lastIndexOf(10) + 1;  // Whole lines only: the last one may be on its way.
        this.from += end;
        const lines = new TextDecoder().decode(bytes.subarray(0, end)).split("\n").filter(Boolean);
        for (const line of lines)
            this.take(JSON.parse(line));
        if (lines.length)
            this.heard_at = performance.now() / 1000;
        // What still writes them locks them, but not all file systems tell.
        this.is_killed = this.care === "elsewhere" && !this.end && !is_open && performance.now() / 1000 - this.heard_at > 5;
    }

    take(event) {
        const { stage, time_s = this.clock_s } = event;
        this.zero = Math.min(this.zero, performance.now() / 1000 - time_s);
        if (event.event === "stages") {
            for (const { stage: name, state, expected_s } of event.stages)
                if (state === "waiting" || state === "stored")
                    this.stages.set(name, { state: state === "stored" ? "done" : state, expected_s });
        } else if (event.event === "begin")
            this.stages.set(stage, { ...this.stages.get(stage), state: "running", began: time_s, begun: time_s });
        else if (event.event === "progress")
            this.advance(stage, event, time_s);
        else if (event.event === "end") {
            this.stages.set(stage, { ...this.stages.get(stage), state: { failed: "failed", interrupted: "waiting" }[event.state] ?? "done" });
            if (event.error)
                this.problems.push(event.error);
        } else if (event.event === "file")
            this.files.add(`${stage}/${event.path}`);
        else if (event.event === "problems")
            this.problems.push(...event.problems.map(problem => problem.text ?? problem.message));
        else if (event.event === "message" || event.event === "warning" || event.event === "note") {
            this.note = event.text;
            if (event.event === "warning")
                this.warnings.push(event.text);
        } else if (event.event === "ended" || (event.event === "summary" && this.care === "elsewhere"))
            this.end = event;
    }

    advance(stage, { done, total, unit }, time_s) {
        const known = this.stages.get(stage) ?? { state: "running" };
        if (known.total !== total || known.unit !== unit || done < known.done)
            Object.assign(known, { first: done, began: time_s });
        this.stages.set(stage, Object.assign(known, { done, total, unit, heard: time_s }));
    }

    has(stage) {
        return [...this.files].some(file => file.startsWith(`${stage}/`));
    }

    /// Seconds that a stage still takes: steady steps by their rate, others by it and by past runs, which may have been shorter; 0: unknown.
    leftOf({ state, expected_s = 0, begun, began, done, first, total, heard, unit }) {
        if (state === "waiting")
            return expected_s;
        if (state !== "running")
            return 0;
        const rate = done > first && heard > began ? (done - first) / (heard - began) : 0;
        const by_rate = rate ? Math.max(0, (total - done) / rate - (this.clock_s - heard)) : 0;
        return unit === "steps" && by_rate ? by_rate : Math.max(by_rate, expected_s - (this.clock_s - begun));
    }

    /// Seconds that the whole run still takes, as far as its stages ran before.
    get left_s() {
        return [...this.stages.values()].reduce((sum, each) => sum + this.leftOf(each), 0);
    }

    /// The stage that runs, and the share of it that is done, if that is known.
    get now() {
        const found = [...this.stages].filter(([, { state }]) => state === "running").at(-1);
        if (!found)
            return null;
        const [name, { done, total, unit }] = found;
        return { name, share: total > 0 ? done / total : null, text: total > 0 ? (unit === "steps" ? `step ${done} of ${total}` : `${Math.round(done)} of ${Math.round(total)} ${unit}`) : "" };
    }
}

const isStyleMesh = request => request?.settings.method === "stylemesh";
const parts = (whole, unit) => `${Math.floor(whole / 60)}:${String(Math.floor(whole % 60)).padStart(2, "0")} ${unit}`;
const duration = seconds => seconds < 60 ? `${Math.ceil(seconds)} s` : seconds < 3600 ? parts(seconds, "min") : parts(seconds / 60, "h");
const care_names = { quick: "First look", preview: "Preview", full: "Painting", export: "Export", elsewhere: "Run" };

function showProgress() {
    at("progress").hidden = !watched || Boolean(watched.end);
    if (at("progress").hidden)
        return;
    const now = watched.now;
    at("what").textContent = care_names[watched.care];
    at("detail").textContent = watched.is_killed ? "ended without a word: it was killed. Started again, it goes on" : now ? [now.name, now.text || watched.note].filter(Boolean).join(" · ") : "starting";
    at("left").textContent = watched.left_s && !watched.is_killed ? `about ${duration(watched.left_s)} left` : "";
    at("bar").firstElementChild.style.width = `${100 * (now?.share ?? 0)}%`;
    at("cancel").hidden = watched.care === "elsewhere";
    const keeps = running?.keeps, steps = watched.stages.get("texture");
    at("keep").hidden = watched.care !== "full" || !isStyleMesh(watched.request);
    at("keep").disabled = keeps || steps?.state !== "running" || steps.unit !== "steps";
    at("keep").textContent = keeps ? "Stopping…" : "Stop and keep";
    at("keep").title = keeps ? "StyleMesh ends after the step that it is at" : at("keep").disabled ? "StyleMesh has not made its first step, or has made its last: there is nothing to stop" : "End StyleMesh after this step and keep what is there as the result (K)";
    at("stages").hidden = watched.care === "quick" || watched.care === "preview";  // They would hide what is looked at.
    at("stages").replaceChildren(...[...watched.stages].map(([name, { state }]) => {
        const item = element("li", { textContent: name });
        item.dataset.state = state;
        return item;
    }));
}

/// Whether what a run makes is what is looked at: neither another scan nor an older painting.
const isMine = run => watched === run && run.scan === chosen.scan && !run.aside;

/// Shows what the run has made so far, the best of it only.
async function showResults(run) {
    const { out } = run;
    const mine = () => isMine(run);
    const photo = async () => {
        const bytes = await bytesAt(`${out}photo.glb`);
        if (!mine())
            throw new Error("something else was chosen");
        return bytes;
    };
    if (!mine())
        return;
    if (run.view && run.has("view") && run.has("photo_view")) {
        if (run.newest === "view")
            return;
        const bytes = await bytesAt(`${out}view.glb`);
        if (mine())
            await view.glimpsed(bytes, photo);
        run.newest = "view";
        shown_scan = run.scan;
        return;
    }
    const stays = view.has === "painting" && shown_scan === run.scan && !run.only_photo;  // Nothing lesser takes its place.
    if (run.has("view") && run.has("photo_view")) {
        if (run.newest === "view")
            return;
        const bytes = await bytesAt(`${out}view.glb`);
        if (mine())
            await view.painted(bytes, photo);
        run.newest = "view";
    } else if (run.has("photo_view") && !stays) {
        if (run.newest === "photo")
            return;
        const bytes = await bytesAt(`${out}photo.glb`);
        if (mine())
            await view.photographed(bytes);
        run.newest = "photo";
    } else if (run.has("mesh_view") && !stays && !run.newest) {
        const bytes = await bytesAt(`${out}mesh.glb`);
        if (mine())
            await view.mesh(bytes);
        run.newest = "mesh";
    } else
        return;
    shown_scan = run.scan;
}

/// The texture as it grows, on the room with the photo.
async function showGrowth(run) {
    if (run.care !== "full" || !isMine(run) || run.stages.get("texture")?.state !== "running" || !run.has("photo_view") || performance.now() - run.grown_at < run.pause_ms)
        return;
    run.grown_at = performance.now();
    const response = await fetch(`${run.out}progress/texture/texture.png?optional`);
    if (response.status !== 200)
        return;
    const picture = await response.blob();
    run.pause_ms = picture.size === run.grown_size ? Math.min(2 * run.pause_ms, 12000) : 1500;  // There is a new one rarely.
    if (picture.size === run.grown_size)
        return;
    run.grown_size = picture.size;
    run.photo ??= await bytesAt(`${run.out}photo.glb`);
    if (isMine(run) && !run.end) {
        await view.growing(run.photo, picture);
        shown_scan = run.scan;
    }
}

/// Of a run elsewhere: the newest picture of the stage that runs, and then its first GLB.
async function showElsewhere(run) {
    const stage = run.now?.name;
    if (stage && performance.now() - run.grown_at > 2000) {
        run.grown_at = performance.now();
        const [own, combination] = stage.split("@");  // A sweep has a folder for each of its combinations.
        for (const name of ["view.png", "texture.png"]) {
            const response = await fetch(`${run.out}${combination ? `${encodeURIComponent(combination)}/` : ""}progress/${encodeURIComponent(own)}/${name}?optional`);
            if (response.status !== 200)
                continue;
            URL.revokeObjectURL(at("newest").src);
            at("newest").src = URL.createObjectURL(await response.blob());
            break;
        }
    }
    at("newest").hidden = !stage || !at("newest").src;
    const file = [...run.files].map(each => each.slice(each.indexOf("/") + 1)).find(each => each.endsWith(".glb"));
    const base = run.run === "." ? folder.folder : `${folder.folder}/${run.run}`;
    if (!run.end || run.is_shown || !file?.startsWith(`${base}/`))
        return;
    run.is_shown = true;
    at("newest").hidden = true;
    const name = file.slice(base.length + 1);
    const bytes = await bytesAt(run.out + addressOf(name));
    try {
        await view.photographed(bytes);
    } catch (error) {
        complain(`${name} cannot be shown here: ${error.message}`);
    }
}

async function ended(run) {
    const { exit_code, canceled, error } = run.end;
    const failed = exit_code !== 0 && !canceled && run.care !== "elsewhere";
    if (run.care === "full")  // An error of this scan stays to be read.
        later = later && (failed ? run.scan !== chosen.scan : JSON.stringify(wordsOf(run.request ?? chosen)) !== JSON.stringify(wordsOf(chosen)));
    if (failed) {
        if (run.view && run.again && run.problems.some(problem => problem.includes("shows nothing of the mesh")))
            return paint("quick", true, false);
        const text = [...run.problems, error].filter(Boolean).join("\n") || run.note || "The run ended for an unknown reason.";
        settings.complain(text);
        complain(text);
        return tell();
    }
    if (canceled)
        return say("canceled");
    if (run.care === "export")
        return offerFiles(run);
    if (isMine(run))
        settings.advise(run.warnings);
    if (run.only_photo)
        return say("StyleMesh has no preview: this is the photo");
    say(`${care_names[run.care].toLowerCase()} ready in ${duration(Math.max((performance.now() - run.began) / 1000, run.clock_s))}`);
    if (run.care === "quick" && run === watched && run.again)
        await paint("preview");
    if (run.care === "full") {
        if (!later && !run.aside) {
            await refresh();
            chosen.settings = paintings.find(({ id }) => id === run.id)?.request.settings ?? chosen.settings;  // It may have been stopped and kept.
            settings.show(chosen.settings);
            shown = run.id;
            tell();
        }
        if (run.newest === "view")
            await saveThumbnail(run.id);
    }
}

const wordsOf = ({ scan, picture, settings: values }) => [scan, picture, Object.entries(values).sort()];

async function saveThumbnail(id) {
    const picture = await view.thumbnail();
    await fetch(`api/thumbnail?id=${id}`, { method: "PUT", body: picture });
    versions.set(id, Date.now());
    await refresh();
}

function offerFiles(run) {
    const stage = run.has("taken") ? "taken/" : "glb/";
    const files = [...run.files].filter(file => file.startsWith(stage)).map(file => file.slice(stage.length));
    for (const file of files) {
        const [, inner] = file.split(`/${run.id}/out/`);
        const link = element("a", { href: `${run.out}${addressOf(inner)}`, download: inner.split("/").at(-1) });
        link.click();
    }
    at("taken").textContent = files.length ? `Saved; also in ${files[0].slice(0, files[0].lastIndexOf("/"))}` : "";
    at("taken").title = files.join("\n");
}

/// `view`: it paints only what was in sight.
function follow({ id, care, serial, request }, again = false) {
    at("newest").hidden = true;
    const log = care === "export" ? "export" : id === "preview" ? `log${serial}` : "log";
    watched = Object.assign(new Watch(`painting/${id}/${log}.jsonl`, `painting/${id}/out/`, care), { id, again, request, scan: request?.scan, view: Boolean(request?.view), only_photo: care !== "full" && isStyleMesh(request), began: performance.now() });
    complain(null);
    say("");
    showProgress();
}

async function paint(care, again = false, in_sight = shown_scan === chosen.scan && ["photo", "painting"].includes(view.has)) {
    if (isBusy())
        later = care !== "full" || later;
    if (!chosen.scan || !chosen.picture || isBusy())
        return;
    complain(null);
    const request = { scan: chosen.scan, picture: chosen.picture, settings: chosen.settings, care, ...(care === "quick" && in_sight ? { view: view.sight } : {}) };
    const { id, serial } = await ask("api/paint", request);
    seen_serial = serial;
    running = { id, care, serial, request };
    if (care !== "full")
        shown = "preview";
    follow(running, again);
    tell();
}

let waiting = 0;
/// A first look soon, which sharpens by itself. StyleMesh, which takes hours, has only the photo to begin with.
function preview() {
    clearTimeout(waiting);
    if (watched)
        watched.aside = false;
    say("");
    complain(null);
    if (isStyleMesh(chosen))
        return running || shown_scan !== chosen.scan || view.has !== "photo" ? guarded(() => paint("preview"))() : undefined;
    waiting = setTimeout(guarded(() => {
        waiting = 0;
        return paint("quick", true);
    }), 200);
}

// What is chosen.

function remember() {
    past.push(structuredClone({ ...chosen, shown }));
    if (past.length > 100)
        past.shift();
}

function choose(change) {
    remember();
    Object.assign(chosen, change);
    if (change.scan && isStyleMesh(chosen) && lackOf(chosen.scan)) {
        chosen.settings = settings.common(chosen.settings);
        settings.show(chosen.settings);
    }
    if (chosen.scan !== shown_scan) {
        view.clear();
        shown_scan = null;
    }
    shown = "preview";
    tell();
    preview();
}

async function open(painting) {
    const { scan, picture, settings: values } = painting.request;
    Object.assign(chosen, { scan, picture, settings: values });
    shown = painting.id;
    settings.show(values);
    if (running?.id === painting.id)
        follow(running);
    else if (!isBusy())
        watched = null;
    else if (watched)
        watched.aside = true;
    later = false;
    complain(painting.state === "failed" ? "This painting failed; Paint tries again." : null);
    tell();
    if (painting.state === "done") {
        const out = `painting/${painting.id}/out/`;
        const bytes = await bytesAt(`${out}view.glb`, "The results of this painting are gone; Paint makes them again.");
        if (shown !== painting.id)
            return;
        await view.painted(bytes, () => bytesAt(`${out}photo.glb`));
        shown_scan = scan;
        if (!painting.thumbnail)
            await saveThumbnail(painting.id);
    }
}

const undo = guarded(async () => {
    const before = past.pop();
    if (!before)
        return;
    Object.assign(chosen, { scan: before.scan, picture: before.picture, settings: before.settings });
    settings.show(chosen.settings);
    const painting = paintings.find(each => each.id === before.shown);
    if (painting)
        await open(painting);
    else {
        shown = before.shown;
        if (chosen.scan !== shown_scan)
            view.clear();
        tell();
        preview();
    }
});

// What the page shows beside the room.

const lackOf = scan => folder.scans.some(({ name, kind }) => name === scan && kind !== "recording") ? "StyleMesh paints through the pictures of a recording, which a model or splats do not have" : lack;

/// A recording's own picture; of anything else what was painted of it last, or else what the page draws.
function pictureOfScan({ name, thumbnail }) {
    if (thumbnail)
        return `picture/${addressOf(thumbnail)}`;
    const painting = paintings.find(each => each.request.scan === name && each.thumbnail);
    return painting ? `painting/${painting.id}/thumb.jpg?${versions.get(painting.id) ?? ""}` : thumbnails.at(name);
}

function tell() {
    at("empty").hidden = view.has !== "nothing";
    at("empty").textContent = watched?.run ? (watched.over ? "This run has written no GLB that could be shown here." : "The result appears here when the run has written a GLB.") : !at("problem").hidden ? "" : chosen.scan ? "Preparing the scan: the mesh appears first, then the photo, then the painting." : folder.scans.length ? "Choose a scan on the left." : "Drop a model here: a GLB or a PLY.";
    at("tools").hidden = view.has === "nothing";
    at("mixing").hidden = view.has !== "painting";
    for (const mode of ["walk", "orbit"])
        at(mode).setAttribute("aria-pressed", at("room").dataset.mode === mode && view.has !== "nothing");
    at("badge").textContent = { nothing: "", mesh: "mesh", photo: watched?.run ? "result" : "photo" }[view.has] ?? (watched?.photo && !watched.end && isMine(watched) ? "as it grows" : shown === "preview" ? "preview" : shown ? `painting ${Number(shown)}` : "");
    at("paint").disabled = !chosen.scan || !chosen.picture || isBusy();
    at("hint").textContent = isBusy() ? "Changes show when the painting is done." : isStyleMesh(chosen) ? "StyleMesh takes hours and has no preview. It can be stopped and kept at any step." : "Changes show as a preview first.";
    at("undo").disabled = !past.length;
    at("take").hidden = !paintings.some(({ id, state }) => id === shown && state === "done");
    const kind = folder.scans.find(({ name }) => name === chosen.scan)?.kind;
    at("take").querySelector("[data-kind=video]").hidden = kind === "model";  // It follows a recording's cameras.
    settings?.suit(kind, chosen.scan);
    settings?.offerStyleMesh(lackOf(chosen.scan));
    showScans(at("scans"), folder.scans, chosen.scan, scan => scan !== chosen.scan && choose({ scan }), pictureOfScan);
    showPictures(at("pictures"), [...folder.pictures, ...folder.shipped], chosen.picture, picture => picture !== chosen.picture && choose({ picture }));
    at("cut").hidden = !folder.is_cut;
    at("watched").hidden = !folder.runs.length;
    showRuns(at("runs"), folder.runs, watched?.run, watchRun);
    showHistory(at("history"), paintings, shown, versions, { open: painting => { remember(); guarded(open)(painting); }, remove: guarded(remove) });
}

async function remove({ id }) {
    await ask("api/delete", { id });
    if (shown === id)
        shown = null;
    await refresh();
}

function watchRun(name) {
    const base = name === "." ? "run/" : `run/${addressOf(name)}/`;
    watched = Object.assign(new Watch(`${base}progress.jsonl`, base, "elsewhere"), { run: name, began: performance.now() });
    view.clear();
    Object.assign(chosen, { scan: null });
    shown = shown_scan = null;
    complain(null);
    tell();
}

async function refresh() {
    const state = await ask("api/state");
    const changed = JSON.stringify([state.paintings, state.running]) !== JSON.stringify([paintings, running]);
    ({ paintings, running } = state);
    if (running && running.serial !== seen_serial && !waiting) {  // What is about to be asked for here comes after it.
        seen_serial = running.serial;  // Begun in another page, or before this one.
        const request = paintings.find(({ id }) => id === running.id)?.request ?? running.request;
        if (request) {
            Object.assign(chosen, { scan: request.scan, picture: request.picture, settings: request.settings });
            settings.show(chosen.settings);
        }
        follow(running);
    }
    if (changed)
        tell();
}

async function look() {
    folder = await ask("api/folder");
    at("folder").textContent = folder.folder;
    document.body.classList.toggle("watching", folder.only_watches);
    settings.offer([...folder.pictures, ...folder.shipped]);
    tell();
    if (lack)  // Not waited for: a file of weights is read, once.
        ask("api/stylemesh").then(found => {
            ({ lack } = found);
            tell();
        }).catch(error => complain(error.message));
}

async function step() {
    await refresh();
    const run = watched;
    if (later && !running && (run?.care !== "full" || run.over)) {
        later = false;
        preview();
    }
    if (!run || (run.over && run.care !== "elsewhere"))
        return;
    await run.poll();
    showProgress();
    if (run.care === "elsewhere")
        await showElsewhere(run);
    else if (run.care !== "export") {
        await showResults(run);
        await showGrowth(run);
    }
    if (run.end && watched === run && !run.over) {
        run.over = true;
        running = null;
        tell();
        await ended(run);
    }
}

async function live() {
    try {
        await step();
        document.body.classList.remove("lost");
    } catch (error) {
        // The server may have been stopped; the page goes on when it is back at this address.
        say(error instanceof TypeError ? "fresco studio does not answer; start it again and open its new address" : error.message);
    }
    setTimeout(live, poll_ms);
}

// Files from outside.

const add = guarded(async files => {
    for (const file of files) {
        say(`adding ${file.name} …`);
        const response = await fetch(`add?name=${encodeURIComponent(file.name)}`, { method: "PUT", body: file });
        const answer = await response.json();
        if (!response.ok)
            throw new Error(answer.error);
        await look();
        say(`${answer.name} added`);
        choose(/\.(glb|ply|spz|splat|sog)$/i.test(answer.name) ? { scan: answer.name } : { picture: answer.name });
    }
});

function hearDrops() {
    let inside = 0;
    const shows = () => { at("drop").hidden = inside <= 0; };
    const hears = (name, action) => document.addEventListener(name, event => {
        if (![...event.dataTransfer.types].includes("Files"))
            return;
        event.preventDefault();
        action(event);
        shows();
    });
    hears("dragenter", () => ++inside);
    hears("dragleave", () => --inside);
    hears("dragover", () => {});
    hears("drop", event => {
        inside = 0;
        add([...event.dataTransfer.files]);
    });
}

function tellMore(title, text, note) {
    const dialog = at("dialog");
    dialog.querySelector("h2").textContent = title;
    dialog.querySelector("pre").textContent = text;
    dialog.querySelector("p").textContent = note;
    dialog.showModal();
}

const keys = `P           paint at full size
Escape      cancel
K           stop StyleMesh and keep what is there
Ctrl-Z      back to what was chosen before
1, 2        walk, orbit
[, ]        from photo to painted
W A S D     walk, while the room has the focus
Tab, Enter  reach and choose everything
Delete      delete the painting in the history that has the focus`;

const cancel = guarded(() => ask("api/cancel", {}));
const keep = guarded(async () => {
    await ask("api/keep", {});
    await refresh();
    showProgress();
});
const full = guarded(() => paint("full"));
const mix = share => {
    at("mix").value = share;
    view.mix(Number(at("mix").value));
};

function hearKeys() {
    const actions = {
        p: full, k: () => at("keep").click(), Escape: () => running && cancel(), 1: () => view.move("walk"), 2: () => view.move("orbit"), "?": () => at("keys").click(),
        "[": () => mix(Number(at("mix").value) - 0.1), "]": () => mix(Number(at("mix").value) + 0.1),
    };
    document.addEventListener("keydown", event => {
        const typing = event.target.matches("input[type=number], select") || at("dialog").open;
        const types = at("dialog").open || (event.target.type === "number" && event.target.value !== event.target.defaultValue);
        if (event.key.toLowerCase() === "z" && !event.shiftKey && (event.ctrlKey || event.metaKey) && !types) {
            event.preventDefault();
            undo();
        } else if (!event.ctrlKey && !event.metaKey && !event.altKey && !typing)
            (actions[event.key] ?? actions[event.key.toLowerCase()])?.();
    });
}

function hearButtons() {
    at("paint").addEventListener("click", full);
    at("cancel").addEventListener("click", cancel);
    at("keep").addEventListener("click", keep);
    at("undo").addEventListener("click", undo);
    at("keys").addEventListener("click", () => tellMore("Keyboard", keys, ""));
    for (const mode of ["walk", "orbit"])
        at(mode).addEventListener("click", () => view.move(mode));
    at("mix").addEventListener("input", () => view.mix(Number(at("mix").value)));
    at("add").addEventListener("click", () => at("file").click());
    at("file").addEventListener("change", () => add([...at("file").files]));
    for (const button of at("take").querySelectorAll("[data-kind]"))
        button.addEventListener("click", guarded(async () => {
            const { serial } = await ask("api/take", { id: shown, kind: button.dataset.kind });
            seen_serial = serial;
            follow({ id: shown, care: "export", serial });
        }));
    at("pipeline").addEventListener("click", guarded(async () => {
        const { text, command, folder: place } = await ask(`api/pipeline?id=${shown}`);
        tellMore("As a pipeline", `${text}\n$ cd '${place.replaceAll("'", `'\\''`)}'\n$ ${command}`, "These lines make exactly this painting, without the studio.");
    }));
    window.addEventListener("focus", guarded(look));
}

async function begin() {
    settings = new Settings(await ask("api/declarations"), () => choose({ settings: { ...settings.values } }));
    view.onchange = tell;
    hearButtons();
    hearKeys();
    hearDrops();
    await look();
    await refresh();
    if (!chosen.picture)
        chosen.picture = folder.shipped[0] ?? folder.pictures[0] ?? null;
    const newest = paintings.find(({ state }) => state === "done");
    live();
    if (!running && folder.runs.includes("."))
        watchRun(".");
    else if (!running && newest)
        await open(newest);
    else if (!running && folder.scans.length === 1)
        choose({ scan: folder.scans[0].name });
    tell();
}

guarded(begin)();
