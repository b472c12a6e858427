// Begins: the data are in the page, in the form of run.json or of sweep.json.

if (typeof document !== "undefined")
    document.addEventListener("DOMContentLoaded", () => {
        const [data, media] = ["data", "media"].map(id => JSON.parse(document.getElementById(id).textContent));
        document.title = `${data.pipeline.name} · fresco`;
        document.getElementById("loading").remove();
        (data.combinations ? sweepPage : runPage)(data, media);
    });
