// What there is to choose from: scans, pictures, runs elsewhere, and the paintings made here. Names come from files: they are set as text only.

const addressOf = name => name.split("/").map(encodeURIComponent).join("/");
const shortName = name => name.split("/").at(-1).replace(/\.[^.]+$/, "").replaceAll("_", " ");

/// `make()` gives the children; it is called only where `key` has changed, since a folder may have thousands of pictures.
function replaceKeepingFocus(place, key, make) {
    const text = JSON.stringify(key);
    if (place.key === text)
        return;
    place.key = text;
    const children = make();
    const focused = place.contains(document.activeElement) ? document.activeElement.dataset.name : null;
    place.replaceChildren(...children);
    if (focused)
        [...place.querySelectorAll("button")].find(button => button.dataset.name === focused)?.focus();
}

function choice(name, chosen, choose, ...children) {
    const button = element("button", { title: name }, ...children);
    button.dataset.name = name;
    button.setAttribute("aria-pressed", name === chosen);
    button.addEventListener("click", () => choose(name));
    return button;
}

/// `pictureOf(scan)`: the address of its picture, or null.
function showScans(place, scans, chosen, choose, pictureOf) {
    const sources = scans.map(pictureOf);
    replaceKeepingFocus(place, [scans, sources, chosen], () => scans.length ? scans.map(({ name, kind, layout }, i) => {
        const src = sources[i];
        const picture = src ? element("img", { src, alt: "", loading: "lazy" })
            : element("span", { className: "shape", textContent: kind === "recording" ? "scan" : name.split(".").at(-1).toUpperCase() });
        const words = element("span", {}, element("strong", { textContent: name === "." ? "this folder" : name }),
            element("small", { textContent: kind !== "recording" ? kind : layout.replace("layout.", "").replaceAll("_", " ") }));
        return choice(name, chosen, choose, picture, words);
    }) : [element("p", { className: "faint", textContent: "No recording and no model in this folder yet. Drop a GLB or PLY here, or start fresco studio in the folder with your scans." })]);
}

function showPictures(place, pictures, chosen, choose) {
    replaceKeepingFocus(place, [pictures, chosen], () => pictures.map(name => /\.hei[cf]$/i.test(name)
        ? choice(name, chosen, choose, shortName(name))
        : choice(name, chosen, choose, element("img", { src: `picture/${addressOf(name)}`, alt: shortName(name), loading: "lazy" }))));
}

function showRuns(place, runs, chosen, choose) {
    replaceKeepingFocus(place, [runs, chosen], () => runs.map(name => choice(name, chosen, choose, element("span", { className: "shape", textContent: "run" }),
        element("span", {}, element("strong", { textContent: name === "." ? "this folder" : name }), element("small", { textContent: "watch" })))));
}

/// `act`: {open(painting), remove(painting)}.
function showHistory(place, paintings, chosen, versions, act) {
    replaceKeepingFocus(place, [paintings, chosen, [...versions]], () => paintings.length ? paintings.map(painting => {
        const { id, state, request, thumbnail } = painting;
        const picture = thumbnail ? element("img", { src: `painting/${id}/thumb.jpg?${versions.get(id) ?? ""}`, alt: "" })
            : element("span", { className: "shape", textContent: state === "running" ? "painting…" : state });
        const stop = request.settings["texture.stop_at_step"];
        const stopped = stop ? [element("span", { className: "stopped", textContent: `stopped at step ${stop}` })] : [];
        const button = choice(id, chosen, () => act.open(painting), picture, ...stopped, element("small", { textContent: `${Number(id)} · ${shortName(request.picture)}` }));
        button.title = [`Painting ${Number(id)}: ${request.scan} after ${shortName(request.picture)}`, ...Object.entries(request.settings).map(([name, value]) => `${name}: ${value}`)].join("\n");
        const remove = element("button", { className: "remove", textContent: "Delete", title: "Delete this painting (Delete)" });
        const sure = () => {
            if (remove.classList.contains("sure"))
                act.remove(painting);
            remove.classList.add("sure");
            remove.textContent = "Really?";
        };
        remove.addEventListener("click", sure);
        remove.addEventListener("blur", () => {
            remove.classList.remove("sure");
            remove.textContent = "Delete";
        });
        button.addEventListener("keydown", event => {
            if (event.key === "Delete") {
                remove.focus();
                sure();
            }
        });
        return element("div", { className: "painting" }, button, remove);
    }) : [element("p", { textContent: "Paintings appear here." })]);
}
