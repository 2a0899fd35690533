// The page: a form, the progress of the channels, dialogs, the listing.

import { JobState, attend, connect, firstError, listing, sentence, submit, watch } from "./job.js";

const part = (id) => document.getElementById(id);

function print(text) {
  part("messages").append(`${text}\n`);
}

function ask({ dialog, values, problem }) {
  const answers = {};
  for (const field of dialog.fields.filter((field) => field.variable)) {
    const now = values[field.variable]?.value.value ?? "";
    const text = window.prompt(`${problem ? `${problem}\n` : ""}${dialog.title}\n${field.label}`, now);
    if (text === null) {
      return undefined;
    }
    answers[field.variable] = text;
  }
  return answers;
}

async function run() {
  const files = [...part("programs").files].map(async (file) => ({
    name: file.name,
    bytes: new Uint8Array(await file.arrayBuffer()),
  }));
  const server = await connect(part("server").value, part("token").value);
  const job = await submit(server, part("machine").value, await Promise.all(files));
  print(`job ${job}`);
  attend(server, job, ask).catch((error) => print(`dialogs are no longer answered: ${sentence(error)}`));
  const ended = await watch(server, job, {
    progress: (channels, cancelling) => {
      const parts = channels.map((c) => `${c.name} ${c.percent.toFixed(0)} %`);
      part("progress").textContent = (cancelling ? ["cancelling", ...parts] : parts).join(", ");
    },
    event: ({ channel, line, kind }) =>
      kind.case === "diagnostic" && print(`channel ${channel} line ${line}: ${kind.value.number} ${kind.value.text}`),
  });
  print(`${JobState[ended.state]} after ${Math.round(Number(ended.makespanNs) / 1e6) / 1e3} s of machine time ${ended.error}`);
  print(firstError(ended));
  part("listing").textContent = ended.error ? "" : await listing(server, job);
}

part("form").addEventListener("submit", (event) => {
  event.preventDefault();
  part("messages").textContent = "";
  run().catch((error) => print(sentence(error)));
});
