// The same as the page, for a terminal: Node speaks gRPC-Web as browsers do.
//
//   node submit_and_watch.js --machine fanuc-2path-lathe upper.nc lower.nc

import { readFileSync, writeFileSync } from "node:fs";
import { basename } from "node:path";
import { parseArgs } from "node:util";
import { JobState, attend, connect, firstError, listing, sentence, submit, watch } from "./job.js";

async function main() {
  const { values: options, positionals: programs } = parseArgs({
    allowPositionals: true,
    options: {
      server: { type: "string", default: "127.0.0.1:7878" },
      machine: { type: "string", default: "fanuc-mill" },
      listing: { type: "string", default: "job.lce" },
      set: { type: "string", multiple: true, default: [] },
    },
  });
  const values = Object.fromEntries(options.set.map((text) => [text.split("=", 1)[0], text.slice(text.indexOf("=") + 1)]));
  const server = await connect(`http://${options.server}`, process.env.COUNTERPOINT_TOKEN);
  const job = await submit(server, options.machine, programs.map((path) => ({ name: basename(path), bytes: readFileSync(path) })));
  console.error(`job ${job}`);
  const ask = ({ dialog, problem }) => {
    console.log(`dialog '${dialog.name}': ${dialog.title} ${problem}`);
    return problem ? undefined : values;
  };
  const attended = attend(server, job, ask).catch((error) =>
    console.error(`dialogs are no longer answered: ${sentence(error)}`),
  );
  const ended = await watch(server, job, {
    progress: (channels, cancelling) => {
      channels.forEach((c) => console.error(`${c.name}: ${c.percent.toFixed(0)} %, block ${c.blocks}`));
      if (cancelling) {
        console.error("cancelling");
      }
    },
    event: ({ channel, line, kind }) =>
      kind.case === "diagnostic" && console.log(`channel ${channel} line ${line}: ${kind.value.number} ${kind.value.text}`),
  });
  await attended;
  console.log(`${JobState[ended.state]} after ${(Math.round(Number(ended.makespanNs) / 1e6) / 1e3).toFixed(3)} s of machine time`);
  if (ended.error) {
    throw new Error(ended.error);
  }
  if (ended.firstError) {
    console.error(firstError(ended));
  }
  writeFileSync(options.listing, await listing(server, job));
  return ended.state === JobState.SUCCEEDED ? 0 : 1;
}

main().then(
  (code) => (process.exitCode = code),
  (error) => {
    console.error(sentence(error));
    process.exitCode = error.unreachable ? 3 : 2;
  },
);
