// The page of one run, from its run.json and from the pictures made for it.

const badge = state => element("span", { class: `badge ${state === "done" ? "good" : "bad"}` }, state);

function runHeading(data, media) {
    const count = (...states) => data.stages.filter(({ state }) => states.includes(state)).length;
    const failed = count("failed");
    const parts = [`${count("ran", "failed")} of ${data.stages.length} stages ran`, `${count("stored", "not needed")} were stored already`, failed && `${failed} failed`];
    const combination = Object.entries(data.pipeline.combination).map(([axis, value]) => element("span", { class: "chip" }, `${axis}: ${value}`));
    return element("header", { class: "page" },
        element("div", {},
            element("h1", {}, data.pipeline.name, " ", badge(data.outcome)), combination.length ? element("p", {}, combination) : null,
            element("p", {}, `${parts.filter(Boolean).join(", ")}; ${durationText(data.seconds)} on ${counted(data.cores, "core")}.`),
            element("p", { class: "soft" }, [data.time.replace("T", " ").replace(/:\d\dZ$/, " UTC"), `fresco ${data.fresco}`, data.processor].join(" · "))),
        element("div", { class: "given" }, inputPictures(data, media)));
}

const problemBoxes = data => data.problems.filter(({ kind }) => kind === "error").map(({ text }) => element("div", { class: "error" }, text));

const noteBoxes = media => media.flatMap(entry => (entry.notes ?? []).map(note => element("p", { class: "note" }, entry.stage ? `${entry.stage}: ${note}` : note)));

/// A section with a part for each stage that has one.
function perStage(title, data, part) {
    const parts = data.stages.map(stage => [stage, part(stage)]).filter(([, nodes]) => nodes && nodes.length !== 0);
    return parts.length ? section(title, parts.map(([stage, nodes]) => [element("h3", {}, stage.name), nodes])) : null;
}

function filesSection(files) {
    const shown = 200;
    if (!files.length)
        return null;
    const rows = files.slice(0, shown).map(({ name, stage, bytes }) => [link(name, name), stage, element("span", { class: "number" }, bytesText(bytes))]);
    return section("Files", tableOf(["file", "stage", "size"], rows), files.length > shown ? element("p", { class: "soft" }, `… and ${files.length - shown} more`) : null);
}

/// A word as a shell reads it back.
const shellWord = word => /^[\w@%+=:,./-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`;

function originSection(data) {
    const versions = Object.assign({}, ...data.stages.map(stage => stage.versions));
    return section("How it was made",
        element("pre", { class: "command" }, data.command.map(shellWord).join(" ")),
        element("p", { class: "soft" }, `in ${data.directory}`),
        data.pipeline.texts.map(({ file, text }) => folded(file, element("pre", {}, text))),
        Object.keys(versions).length ? folded("versions", listed(versions)) : null);
}

/// The parts of the page that viewers draw: each of globalThis.viewerParts is {place, make(data, media, earlier parts)}, where make returns
/// {node, entries: those of media that are shown in it, start: called when it is on the page}.
function viewerPartsOf(data, media) {
    const parts = [];
    for (const { make } of (globalThis.viewerParts ?? []).sort((a, b) => a.place - b.place))
        parts.push(make(data, media, parts));
    return parts;
}

function runPage(data, media) {
    const parts = viewerPartsOf(data, media);
    const shown = new Set(parts.flatMap(part => part.entries ?? []));
    const rest = media.filter(entry => !shown.has(entry));
    const charts = stage => curveCharts(stage.curves);
    document.body.append(element("main", {}, runHeading(data, rest), problemBoxes(data), noteBoxes(media),
        section("The pipeline", graphOf(data.stages)), parts.map(part => part.node), titledPictures(data, rest), otherPictures(data, rest),
        perStage("Frames kept and dropped", data, stage => stage.figures.judged_frames && judgedChart(stage.figures.judged_frames)),
        perStage("How it went", data, stage => charts(stage).length ? element("div", { class: "charts" }, charts(stage)) : null),
        section("Stages", data.stages.map(stageCard)), filesSection(data.files), originSection(data)));
    parts.forEach(part => part.start?.());
}
