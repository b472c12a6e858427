// The pipeline as boxes from left to right.

const box = { height: 46, row: 62, wire: 20, margin: 4 };

/// Width of a box and of a column: narrower where there are many layers, as long as their texts can be read.
function widthsOf(layers) {
    const page = 1190;
    const column = Math.min(176, Math.max(108, (page - 2 * box.margin) / Math.max(1, layers)));
    return { column, width: Math.round(0.75 * column + (176 - column) * 0.12) };
}

/// Places the stages by what they wait for, and in each layer near what they are joined to: {boxes: [{stage, layer, row}], ways: [[box,
/// …]], layers: [number of boxes]}. The stages' boxes come first, in their order; the others are where a wire passes through a layer. Several wires
/// between two stages are one way.
function layoutOf(stages) {
    const numbers = new Map(stages.map((stage, number) => [stage.name, number]));
    const edges = stages.flatMap((stage, to) => [...new Set(stage.inputs.map(input => numbers.get(input.stage)).filter(from => from !== undefined))].map(from => [from, to]));
    const boxes = stages.map((_, stage) => ({ stage, layer: 0, row: 0 }));
    // Stages are in a topological order, and edges in that of their ends: one pass.
    for (const [from, to] of edges)
        boxes[to].layer = Math.max(boxes[to].layer, boxes[from].layer + 1);
    const ways = edges.map(([from, to]) => {
        const way = [from];
        for (let layer = boxes[from].layer + 1; layer < boxes[to].layer; ++layer)
            way.push(boxes.push({ stage: -1, layer, row: 0 }) - 1);
        return [...way, to];
    });
    const layers = Array.from({ length: Math.max(0, ...boxes.map(({ layer }) => layer + 1)) }, () => []);
    boxes.forEach((place, number) => place.row = layers[place.layer].push(number) - 1);
    const joined = boxes.map(() => ({ left: [], right: [] }));
    for (const way of ways)
        for (let i = 1; i < way.length; ++i) {
            joined[way[i]].left.push(way[i - 1]);
            joined[way[i - 1]].right.push(way[i]);
        }
    // Each box near the mean of its neighbors in the layer before, then in the layer behind, and so on.
    for (const side of ["left", "right", "left", "right", "left", "right"])
        for (const layer of side === "left" ? layers : [...layers].reverse()) {
            const wanted = new Map(layer.map(number => {
                const rows = joined[number][side].map(other => boxes[other].row);
                return [number, rows.length ? rows.reduce((sum, row) => sum + row, 0) / rows.length : boxes[number].row];
            }));
            layer.sort((a, b) => wanted.get(a) - wanted.get(b)).forEach((number, row) => boxes[number].row = row);
        }
    return { boxes, ways, layers: layers.map(layer => layer.length) };
}

const shortened = (text, most) => text.length <= most ? text : text.slice(0, most - 1) + "…";

const wasStored = stage => stage.state === "stored" || stage.state === "not needed";

function stateText(stage) {
    if (stage.state === "ran")
        return durationText(stage.seconds);
    return wasStored(stage) ? "stored" + (stage.seconds > 0 ? ` (${durationText(stage.seconds)})` : "") : stage.state;
}

/// The middle of each box's left side, and the size of all: layers stand around one line, and wires need less room than stages.
function placesOf({ boxes, layers }) {
    const tall = ({ stage }) => stage < 0 ? box.wire : box.row;
    const columns = layers.map((_, layer) => boxes.map((each, number) => ({ ...each, number })).filter(each => each.layer === layer).sort((a, b) => a.row - b.row));
    const { column: step, width: own } = widthsOf(layers.length);
    const heights = columns.map(column => column.reduce((sum, each) => sum + tall(each), 0));
    const height = Math.max(0, ...heights);
    const places = [];
    columns.forEach((column, layer) => column.reduce((y, each) => {
        places[each.number] = { x: box.margin + layer * step, y: box.margin + y + tall(each) / 2 };
        return y + tall(each);
    }, (height - heights[layer]) / 2));
    return { places, width: 2 * box.margin + Math.max(0, layers.length - 1) * step + own, own, bend: (step - own) / 2, height: 2 * box.margin + height };
}

function graphOf(stages) {
    const drawing = layoutOf(stages);
    const { places, width, height, own, bend } = placesOf(drawing);
    const fitting = (text, letter) => shortened(text, Math.floor((own - 14) / letter));
    const wires = drawing.ways.map(way => svg("path", { class: "wire", d: way.slice(1).map((number, i) => {
        const [from, to] = [places[way[i]], places[number]];
        const x = from.x + own;
        return `${i === 0 ? `M${x} ${from.y}` : `H${x}`}C${x + bend} ${from.y} ${to.x - bend} ${to.y} ${to.x} ${to.y}`;
    }).join("") }));
    const drawn = stages.map((stage, number) => svg("a", { href: `#stage-${number}` },
        svg("g", { class: `stage ${stage.state.replaceAll(" ", "-")}`, transform: `translate(${places[number].x} ${places[number].y - box.height / 2})` },
            svg("title", {}, `${stage.name}: ${stage.type}\n${stage.help}`),
            svg("rect", { width: own, height: box.height, rx: 7 }),
            svg("text", { x: 10, y: 19, class: "name" }, fitting(stage.own_name ?? stage.name, 8)),
            svg("text", { x: 10, y: 36 }, fitting(stateText(stage), 6.4)))));
    return scrolled(svg("svg", { class: "graph", viewBox: `0 0 ${width} ${height}`, style: `min-width: ${Math.min(width, 640)}px; max-width: ${width}px`, role: "img", "aria-label": "The pipeline's stages and how they are joined" }, wires, drawn));
}
