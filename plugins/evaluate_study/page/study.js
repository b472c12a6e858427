"use strict";
(() => {
    // study: {study, questions: [text], mixes_questions, pictures: [data URI], hints: by picture [[question or null, left, top, width,
    // height], …], strata: [[[picture, picture], …], …], pairs_count}
    // Pictures have only numbers: the key that the study's owner keeps says which method made which.
    const study = JSON.parse(document.getElementById("study-data").textContent);
    const element = id => document.getElementById(id);
    const storage = "fresco-study-" + study.study;

    // ---- Numbers that depend only on the participant's code: xorshift (Marsaglia, 2003), seeded by FNV-1a.
    function makeRandom(text) {
        let state = 0x811c9dc5;
        for (const byte of new TextEncoder().encode(text))
            state = Math.imul(state ^ byte, 0x01000193) >>> 0;
        state = state || 1;
        const next = () => {
            state ^= state << 13;
            state ^= state >>> 17;
            state ^= state << 5;
            state >>>= 0;
            return state / 4294967296;
        };
        for (let i = 0; i < 16; ++i)
            next();
        return next;
    }

    function shuffled(list, random) {
        const result = list.slice();
        for (let i = result.length - 1; i > 0; --i) {
            const j = Math.floor(random() * (i + 1));
            [result[i], result[j]] = [result[j], result[i]];
        }
        return result;
    }

    // ---- What a participant is asked: evenly spread over the questions and over the pairs of methods, one question after the
    // other or mixed, in an order and with sides of the participant's own.
    function makePlan(code) {
        const random = makeRandom(study.study + ":" + code);
        const questions = shuffled(study.questions.map((_, i) => i), random);
        const cells = [];
        for (const question of questions)
            for (const pairs of study.strata)
                cells.push({question, left: shuffled(pairs, random)});
        const trials = [];
        for (const order = shuffled(cells, random); trials.length < study.pairs_count && order.some(cell => cell.left.length > 0);)
            for (const cell of order)
                if (cell.left.length > 0 && trials.length < study.pairs_count) {
                    const [one, other] = cell.left.pop();
                    const swap = random() < 0.5;
                    trials.push({question: cell.question, left: swap ? other : one, right: swap ? one : other});
                }
        if (study.mixes_questions)
            return shuffled(trials, random);
        return questions.flatMap(question => shuffled(trials.filter(trial => trial.question === question), random));
    }

    // ---- Answers so far, by code. A browser may forbid storage: then the page works without, for one sitting.
    function load() {
        try {
            const saved = JSON.parse(window.localStorage.getItem(storage) || "{}");
            return saved !== null && typeof saved === "object" && !Array.isArray(saved) ? saved : {};
        } catch (error) {
            return {};
        }
    }

    function save() {
        try {
            const all = load();
            all[run.code] = run.answers;
            window.localStorage.setItem(storage, JSON.stringify(all));
        } catch (error) {
            // Full or forbidden: the answers are still in the page.
        }
    }

    function savedAnswers(code, plan) {
        const all = load();
        const answers = Object.hasOwn(all, code) && Array.isArray(all[code]) ? all[code] : [];
        const fits = (answer, i) => answer !== null && typeof answer === "object" && i < plan.length &&
            answer.question === plan[i].question && answer.left === plan[i].left && answer.right === plan[i].right &&
            ["left", "right", "neither"].includes(answer.choice) && Number.isFinite(answer.seconds);
        return answers.every(fits) ? answers : [];
    }

    const run = {code: "", plan: [], answers: [], shown: 0, ready: false};

    function show(id) {
        for (const section of document.querySelectorAll("section"))
            section.hidden = section.id !== id;
    }

    // ---- Looking closer. Both pictures share one view: a scale, and the offset in shares of the picture's size.
    const frames = Array.from(document.querySelectorAll(".frame"));
    const view = {scale: 1, x: 0, y: 0};
    const pointers = new Map();
    let traveled = 0;

    function applyView() {
        const least = 1 - view.scale;
        view.x = Math.min(0, Math.max(least, view.x));
        view.y = Math.min(0, Math.max(least, view.y));
        for (const frame of frames) {
            frame.classList.toggle("zoomed", view.scale > 1);
            frame.firstElementChild.style.transform = `translate(${view.x * 100}%, ${view.y * 100}%) scale(${view.scale})`;
        }
    }

    function zoom(factor, at) {
        const scale = Math.min(16, Math.max(1, view.scale * factor));
        view.x = at.x - (at.x - view.x) * scale / view.scale;
        view.y = at.y - (at.y - view.y) * scale / view.scale;
        view.scale = scale;
        applyView();
    }

    function zoomOut() {
        Object.assign(view, {scale: 1, x: 0, y: 0});
        applyView();
    }

    function place(event, frame) {
        const box = frame.getBoundingClientRect();
        return {x: (event.clientX - box.left) / box.width, y: (event.clientY - box.top) / box.height};
    }

    function spread() {
        const [one, other] = Array.from(pointers.values());
        return {distance: Math.hypot(one.x - other.x, one.y - other.y), x: (one.x + other.x) / 2, y: (one.y + other.y) / 2};
    }

    for (const frame of frames) {
        frame.addEventListener("wheel", event => {
            event.preventDefault();
            const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1;
            zoom(Math.exp(-event.deltaY * lines * 0.0025), place(event, frame));
        }, {passive: false});
        frame.addEventListener("pointerdown", event => {
            if (pointers.size === 0)
                traveled = 0;
            pointers.set(event.pointerId, place(event, frame));
            frame.setPointerCapture(event.pointerId);
        });
        frame.addEventListener("pointermove", event => {
            const before = pointers.get(event.pointerId);
            if (!before)
                return;
            const now = place(event, frame);
            const old = pointers.size === 2 ? spread() : null;
            pointers.set(event.pointerId, now);
            traveled += Math.hypot(event.movementX, event.movementY);
            if (old) {
                const moved = spread();
                view.x += moved.x - old.x;
                view.y += moved.y - old.y;
                zoom(moved.distance / Math.max(old.distance, 1e-3), moved);
            } else if (pointers.size === 1) {
                view.x += now.x - before.x;
                view.y += now.y - before.y;
                applyView();
            }
        });
        const release = event => {
            if (!pointers.delete(event.pointerId))
                return;
            const clicked = event.type === "pointerup" && pointers.size === 0 && traveled < 6;
            if (clicked && view.scale > 1)
                zoomOut();
            else if (clicked)
                zoom(3, place(event, frame));
        };
        frame.addEventListener("pointerup", release);
        frame.addEventListener("pointercancel", release);
    }

    // ---- Rectangles where an answer may be seen; the drawing has the picture's shape and lies over it.
    function drawHints(picture, question) {
        const image = element(picture.side);
        const drawing = element(picture.side + "-hints");
        drawing.setAttribute("viewBox", `0 0 ${image.naturalWidth} ${image.naturalHeight}`);
        drawing.replaceChildren(...study.hints[picture.number].filter(hint => hint[0] === null || hint[0] === question).map(hint => {
            const box = document.createElementNS(drawing.namespaceURI, "rect");
            for (const [name, value] of [["x", hint[1] * image.naturalWidth], ["y", hint[2] * image.naturalHeight],
                                         ["width", hint[3] * image.naturalWidth], ["height", hint[4] * image.naturalHeight]])
                box.setAttribute(name, value);
            return box;
        }));
    }

    // ---- One pair after the other
    async function showTrial() {
        const number = run.answers.length;
        if (number === run.plan.length)
            return finish();
        const trial = run.plan[number];
        run.ready = false;
        for (const button of document.querySelectorAll("#choices button"))
            button.disabled = true;
        show("trial");
        zoomOut();
        element("progress").max = run.plan.length;
        element("progress").value = number;
        element("count").textContent = `${number + 1} of ${run.plan.length}`;
        element("question").textContent = study.questions[trial.question];
        element("back").disabled = number === 0;
        element("left").src = study.pictures[trial.left];
        element("right").src = study.pictures[trial.right];
        try {
            await Promise.all([element("left").decode(), element("right").decode()]);
        } catch (error) {
            element("question").textContent = "A picture cannot be shown by this browser. Please tell whoever asked you.";
            throw error;
        }
        if (run.answers.length !== number || element("trial").hidden)
            return;
        for (const side of ["left", "right"])
            drawHints({side, number: trial[side]}, trial.question);
        run.shown = performance.now();
        run.ready = true;
        for (const button of document.querySelectorAll("#choices button"))
            button.disabled = false;
        if (number + 1 < run.plan.length)
            for (const picture of [run.plan[number + 1].left, run.plan[number + 1].right])
                new Image().src = study.pictures[picture];
    }

    function answer(choice) {
        if (!run.ready)
            return;
        const seconds = Math.round((performance.now() - run.shown) / 10) / 100;
        run.answers.push({...run.plan[run.answers.length], choice, seconds});
        save();
        showTrial();
    }

    function back() {
        if (run.answers.length === 0)
            return;
        run.answers.pop();
        save();
        showTrial();
    }

    function finish() {
        run.ready = false;
        const complete = run.answers.length === run.plan.length;
        const result = {format: "fresco.study_answers", version: 1, study: study.study, participant: run.code, complete, answers: run.answers};
        const text = JSON.stringify(result, null, 1) + "\n";
        const link = element("download");
        if (link.href)
            URL.revokeObjectURL(link.href);
        link.href = URL.createObjectURL(new Blob([text], {type: "application/json"}));
        link.download = `study-${study.study.slice(0, 8)}-${run.code}.json`;
        element("text").value = text;
        element("answered").textContent = `You answered ${run.answers.length} of ${run.plan.length} questions.`;
        element("resume").hidden = complete;
        show("end");
        link.focus();
    }

    /// `anew`: another person begins; else whoever was interrupted here goes on.
    function welcome(anew) {
        const unfinished = Object.keys(anew ? {} : load()).filter(code => {
            const plan = makePlan(code);
            const count = savedAnswers(code, plan).length;
            return count > 0 && count < plan.length;
        });
        const letters = "ABCDEFGHJKLMNPQRSTUVWXYZ23456789";
        const fresh = Array.from(crypto.getRandomValues(new Uint8Array(6)), byte => letters[byte % letters.length]).join("");
        element("participant").value = unfinished.length > 0 ? unfinished[unfinished.length - 1] : fresh;
        element("total").textContent = String(makePlan("").length);
        show("welcome");
        tellSaved();
    }

    function tellSaved() {
        const code = element("participant").value;
        const plan = makePlan(code);
        const count = savedAnswers(code, plan).length;
        element("saved").textContent = count === 0 ? "" : `${count} of ${plan.length} answers of this code are kept here: you will go on after them.`;
    }

    element("participant").addEventListener("input", tellSaved);
    element("start").addEventListener("submit", event => {
        event.preventDefault();
        run.code = element("participant").value;
        run.plan = makePlan(run.code);
        run.answers = savedAnswers(run.code, run.plan);
        element("participant").blur();
        showTrial();
    });
    for (const button of document.querySelectorAll("#choices button"))
        button.addEventListener("click", () => answer(button.dataset.choice));
    element("back").addEventListener("click", back);
    element("whole").addEventListener("click", zoomOut);
    element("stop").addEventListener("click", finish);
    element("resume").addEventListener("click", showTrial);
    element("another").addEventListener("click", () => welcome(true));

    const keys = {
        ArrowLeft: () => answer("left"),
        a: () => answer("left"),
        ArrowRight: () => answer("right"),
        b: () => answer("right"),
        ArrowDown: () => answer("neither"),
        n: () => answer("neither"),
        Backspace: back,
        "+": () => zoom(1.5, {x: 0.5, y: 0.5}),
        "-": () => zoom(1 / 1.5, {x: 0.5, y: 0.5}),
    };
    document.addEventListener("keydown", event => {
        if (element("trial").hidden || event.ctrlKey || event.metaKey || event.altKey || event.repeat)
            return;
        const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
        if (!Object.hasOwn(keys, key))
            return;
        event.preventDefault();
        keys[key]();
    });

    welcome(false);
})();
