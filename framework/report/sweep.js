// The page of a matrix, from its sweep.json: what each combination looks like and comes to.

/// Small copies by the path of the file that they show.
const copiesOf = media => new Map(media.flatMap(entry => (entry.pictures ?? []).map(picture => [fileOf(entry, picture), picture.uri])));

/// Of each combination by its name, small copies of the pictures that its stages read and not those of all: [{port, file, uri}].
function inputsOf({ stages, combinations }, media) {
    const known = new Map(media.filter(entry => entry.file && entry.pictures?.length).map(entry => [entry.file, { port: entry.port, file: entry.file, uri: entry.pictures[0].uri }]));
    const files = new Map(stages.map(({ name, inputs }) => [name, inputs.map(({ file }) => file).filter(file => known.has(file))]));
    const read = combinations.map(cell => distinct(cell.stages.flatMap(stage => files.get(stage) ?? [])));
    const differs = file => combinations.length === 1 || !read.every(all => all.includes(file));
    return new Map(combinations.map(({ name }, i) => [name, read[i].filter(differs).map(file => known.get(file))]));
}

function cellOf(cell, copies, inputs) {
    const given = inputs.get(cell.name).map(({ port, file, uri }) => element("img", { src: uri, title: `${port}: ${file}`, alt: file }));
    const pictures = cell.pictures.map(file => link(file, element("img", { loading: "lazy", alt: file, src: copies.get(file) ?? addressOf(file) })));
    const most = 60;
    const files = cell.files.slice(0, most).map(file => element("li", {}, link(file, file)));
    return [
        given.length ? element("div", { class: "given" }, given) : null,
        pictures.length ? element("div", { class: pictures.length > 1 ? "row many" : "row" }, pictures) : element("div", { class: "none" }, "no picture"),
        element("div", { class: "soft" }, badge(cell.state), cell.own_seconds > 0 ? ` · own time ${durationText(cell.own_seconds)}` : "", cell.report ? [" · ", link(cell.report, "report")] : null),
        cell.error ? element("div", { class: "error" }, cell.error) : null,
        files.length ? folded(counted(cell.files.length, "file"), element("ul", {}, files, cell.files.length > most ? element("li", {}, `and ${cell.files.length - most} more`) : null)) : null,
    ];
}

const distinct = values => [...new Set(values)];

/// With two axes or more the last one's values are columns and the one's before are rows; each combination of the others has a table of
/// its own. With one axis, cards.
function combinationTables({ axes, combinations }, copies, inputs) {
    const [row, column] = axes.slice(-2);
    if (axes.length < 2)
        return element("div", { class: "cards" }, combinations.map(cell => element("article", {}, element("h3", {}, cell.name), cellOf(cell, copies, inputs))));
    // "size=2048" names its axis itself.
    const titleOf = cell => axes.slice(0, -2).map(axis => cell.values[axis].startsWith(`${axis}=`) ? cell.values[axis] : `${axis}: ${cell.values[axis]}`).join(", ");
    return distinct(combinations.map(titleOf)).map(title => {
        const cells = combinations.filter(cell => titleOf(cell) === title);
        const [rows, columns] = [row, column].map(axis => distinct(cells.map(cell => cell.values[axis])));
        return [title ? element("h3", {}, title) : null, scrolled(element("table", { class: "sweep" },
            element("thead", {}, element("tr", {}, element("th", {}, `${row} \\ ${column}`), columns.map(value => element("th", {}, value)))),
            element("tbody", {}, rows.map(value => element("tr", {}, element("th", {}, value),
                cells.filter(cell => cell.values[row] === value).map(cell => element("td", {}, cellOf(cell, copies, inputs))))))))];
    });
}

/// Of each stage by its name in the file, the figures in which combinations differ: [{stage, labels, rows: [[combination, text, …]]}].
function figureTables({ stages, combinations }) {
    const known = new Map(stages.map(stage => [stage.name, { ...stage, texts: new Map(figuresOf(stage.figures).map(({ label, value }) => [label, value])) }]));
    return distinct(stages.map(({ own_name }) => own_name)).map(name => {
        const cells = combinations.map(cell => [cell.name, cell.stages.map(stage => known.get(stage)).find(stage => stage.own_name === name)?.texts ?? new Map()]);
        const labels = distinct(cells.flatMap(([, texts]) => [...texts.keys()])).filter(label => distinct(cells.map(([, texts]) => texts.get(label))).length > 1);
        return { stage: name, labels, rows: cells.map(([cell, texts]) => [cell, ...labels.map(label => texts.get(label) ?? "")]) };
    }).filter(({ labels }) => labels.length);
}

function sweepPage(data, media) {
    const states = distinct(data.combinations.map(({ state }) => state)).sort().map(state => `${data.combinations.filter(cell => cell.state === state).length} ${state}`);
    const figures = figureTables(data);
    document.body.append(element("main", { class: "wide" },
        element("header", { class: "page" }, element("div", {}, element("h1", {}, data.pipeline.name),
            element("p", {}, [counted(data.combinations.length, "combination"), ...states].join(" · ")))),
        noteBoxes(media), section("Combinations", combinationTables(data, copiesOf(media), inputsOf(data, media))),
        figures.length ? section("Figures", figures.map(({ stage, labels, rows }, i) =>
            element("details", { open: i === figures.length - 1 }, element("summary", {}, stage), tableOf(["", ...labels], rows)))) : null,
        originSection(data)));
}
