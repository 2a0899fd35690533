// Submits NC programs to a Counterpoint server, watches them live, answers dialogs, and saves the merged listing.
//
//   node submit_and_watch.js --machine fanuc-2path-lathe upper.nc lower.nc

"use strict";

const { createHash, randomUUID } = require("node:crypto");
const fs = require("node:fs");
const path = require("node:path");
const { setTimeout: sleep } = require("node:timers/promises");
const { parseArgs, promisify } = require("node:util");
const grpc = require("@grpc/grpc-js");
const loader = require("@grpc/proto-loader");

const CHUNK = 64 * 1024;
/** Longest time for the first connection, ms. */
const REACH_MS = 1500;

const USAGE = `usage: node submit_and_watch.js [options] PROGRAM...
  --server URL      server [default: COUNTERPOINT_SERVER, or http://127.0.0.1:7878]
  --machine NAME    machine [default: fanuc-mill]
  --listing FILE    file for the merged listing [default: job.lce]
  --set NAME=VALUE  value of a field of a dialog; can be repeated`;
/** Refusals that another request would avoid; others are about the caller or the server. */
const OF_REQUEST = ["INVALID_ARGUMENT", "NOT_FOUND", "ALREADY_EXISTS", "FAILED_PRECONDITION"];

class Unreachable extends Error {}

/** The target and the credentials for gRPC. HOST:PORT means https if COUNTERPOINT_CA names authorities. */
function place(address) {
  const scheme = process.env.COUNTERPOINT_CA ? "https" : "http";
  const whole = address.includes("://") ? address : `${scheme}://${address}`;
  const { protocol, host, port } = URL.canParse(whole) ? new URL(whole) : {};
  if (protocol !== "http:" && protocol !== "https:") {
    throw new Error(`server address '${address}': expected HOST:PORT, http://HOST:PORT or https://HOST:PORT`);
  }
  const secure = protocol === "https:";
  const target = port ? host : `${host}:${secure ? 443 : 80}`;
  if (!secure) {
    return { url: `http://${host}`, target, credentials: grpc.credentials.createInsecure() };
  }
  const [ca, key, certificate] = ["CA", "CLIENT_KEY", "CLIENT_CERT"].map((name) => pem(`COUNTERPOINT_${name}`));
  return { url: `https://${host}`, target, credentials: grpc.credentials.createSsl(ca, key, certificate) };
}

/** The content of the file that a variable names; null without the variable. */
function pem(variable) {
  try {
    return process.env[variable] ? fs.readFileSync(process.env[variable]) : null;
  } catch (error) {
    throw new Error(`${variable}: ${error.message}`);
  }
}

/** Causes of failed connections: a pattern for the text of Node or OpenSSL, and a sentence. */
const CAUSES = [
  [/ECONNREFUSED/, "no server listens at this address"],
  [/ENOTFOUND|EAI_AGAIN|Name resolution failed/, "the host name cannot be resolved"],
  [/ETIMEDOUT|EHOSTUNREACH|ENETUNREACH|too slow/, "the host does not answer"],
  [/wrong version number|packet length too long/, "the server does not encrypt: use http://"],
  [/altnames|not match certificate/, "the certificate of the server is for a different host name"],
  [/has expired|not yet valid/, "the certificate of the server has expired or is not valid yet"],
  [
    /unable to (verify|get)|self[- ]signed/,
    "the certificate of the server is signed by an unknown authority: set COUNTERPOINT_CA to the authority's file",
  ],
  [
    /alert.*certificate|certificate required|handshake failure/,
    "the server requires a client certificate that it knows: set COUNTERPOINT_CLIENT_CERT and COUNTERPOINT_CLIENT_KEY",
  ],
  [/ECONNRESET|GOAWAY|socket|closed|dropped/i, "the server has closed the connection: it may expect https://"],
];

/** The cause of a failed connection, in words. A server with TLS does not tell a client without TLS the cause. */
function reason(details, secure = true) {
  const known = CAUSES.find(([pattern]) => pattern.test(details));
  const other = secure
    ? "the cause is unknown"
    : "the server does not answer without encryption: it may expect https://";
  return known ? known[1] : other;
}

/** An error of a call as a sentence: the server's message names the fault and the remedy. */
function sentence(error) {
  // grpc-js leaves these characters of a message encoded.
  const details = error.details?.replaceAll("%3F", "?").replaceAll("%23", "#");
  switch (error.code) {
    case grpc.status.UNAVAILABLE:
      // A refusal of the server has details; a lost connection has none.
      return error.metadata?.get("grpc-status-details-bin").length > 0
        ? `${details}: try again later`
        : `the connection to the server was lost (${reason(details)}): check that counterpointd is running, then try again`;
    case grpc.status.UNAUTHENTICATED:
      return `${details}: set COUNTERPOINT_TOKEN to a token for this server`;
    default:
      return details || error.message;
  }
}

/** Connects within REACH_MS: one channel, with a stub for each service. */
async function connect(address) {
  const proto = process.env.COUNTERPOINT_PROTO ?? path.join(__dirname, "../../proto");
  const files = ["blobs", "jobs", "operator", "results"].map((name) => `counterpoint/v1/${name}.proto`);
  // 64-bit numbers, such as cursors, stay exact as text.
  const form = { includeDirs: [proto], longs: String, enums: String, defaults: true, oneofs: true };
  const { v1 } = grpc.loadPackageDefinition(loader.loadSync(files, form)).counterpoint;
  const options = { "grpc.keepalive_time_ms": 30_000, "grpc.keepalive_timeout_ms": 10_000 };
  const { url, target, credentials } = place(address);
  const first = new v1.Jobs(target, credentials, options);
  try {
    await promisify(first.waitForReady.bind(first))(Date.now() + REACH_MS);
  } catch {
    // A call on the failed channel returns the cause, for example a certificate that is not accepted.
    const cause = await call(first, "ListJobs", {}).then(
      () => reason("too slow"),
      (error) => reason(error.details, url.startsWith("https:")),
    );
    first.close();
    const advice = "check the address (http or https), and that counterpointd is running";
    throw new Unreachable(`no connection to ${url}: ${cause}; ${advice}`);
  }
  const channelOverride = first.getChannel();
  const stub = (Service) => new Service(target, credentials, { channelOverride });
  return { jobs: first, blobs: stub(v1.Blobs), operator: stub(v1.Operator), results: stub(v1.Results) };
}

function metadata() {
  const metadata = new grpc.Metadata();
  if (process.env.COUNTERPOINT_TOKEN) {
    metadata.set("authorization", `Bearer ${process.env.COUNTERPOINT_TOKEN}`);
  }
  return metadata;
}

/** Makes a unary call. */
function call(stub, name, request) {
  return promisify(stub[name].bind(stub))(request, metadata());
}

function upload(blobs, digest, content) {
  return new Promise((resolve, reject) => {
    const stream = blobs.Upload(metadata(), (error, answer) => (error ? reject(error) : resolve(answer)));
    stream.write({ digest, size: content.length, data: content.subarray(0, CHUNK) });
    for (let at = CHUNK; at < content.length; at += CHUNK) {
      stream.write({ data: content.subarray(at, at + CHUNK) });
    }
    stream.end();
  });
}

/** Uploads the files that the server does not have, and submits the job. The job is stored when this returns. */
async function submit(server, machine, programs) {
  const files = programs.map((file) => {
    const content = fs.readFileSync(file);
    return { path: path.basename(file), digest: createHash("sha256").update(content).digest("hex"), content };
  });
  const missing = await call(server.blobs, "FindMissing", { digests: files.map((file) => file.digest) });
  for (const digest of missing.digests) {
    await upload(server.blobs, digest, files.find((file) => file.digest === digest).content);
  }
  // The same request id gives the same job, so the submit may be repeated after a lost answer.
  const answer = await call(server.jobs, "SubmitJob", {
    requestId: randomUUID(),
    machine,
    programs: files.map(({ path }) => ({ path })),
    files: files.map(({ path, digest }) => ({ path, digest })),
    options: { attended: true },
  });
  return answer.status.jobId;
}

/** Prints diagnostics and progress until the job ends; continues a broken watch at its cursor. */
async function watch(server, jobId) {
  let afterSeq = "0";
  for (let failures = 0; ; failures++) {
    try {
      const request = { jobId, afterSeq, level: "WATCH_LEVEL_DIAGNOSTICS" };
      for await (const message of server.jobs.WatchJob(request, metadata())) {
        failures = 0;
        if (message.content === "ended") {
          return message.ended;
        } else if (message.content === "batch") {
          for (const { channel, line, diagnostic } of message.batch.events.filter((event) => event.diagnostic)) {
            console.log(`channel ${channel} line ${line}: ${diagnostic.number} ${diagnostic.text}`);
          }
          afterSeq = message.batch.lastSeq;
        } else if (message.content === "progress") {
          const channels = message.progress.channels.map((c) => `${c.name}: ${c.percent.toFixed(0)} %, block ${c.blocks}`);
          channels.forEach((text) => console.error(text));
        }
      }
    } catch (error) {
      if (error.code !== grpc.status.UNAVAILABLE || failures >= 10) {
        throw error;
      }
    }
    await sleep(Math.min(100 * 2 ** failures, 10_000) * (0.5 + Math.random() / 2));
  }
}

/** Answers every dialog with its first button of type OK and the values of the command line. */
function attend(server, jobId, values) {
  const stream = server.operator.Attend(metadata());
  stream.on("error", (error) => console.error(`dialogs are no longer answered: ${sentence(error)}`));
  stream.on("data", ({ content, question }) => {
    if (content !== "question") {
      return;
    }
    console.log(`dialog '${question.dialog.name}': ${question.dialog.title}`);
    if (question.problem) {
      console.error(`declined: ${question.problem}`);
      stream.write({ declined: question.id });
    } else {
      stream.write({ answer: { questionId: question.id, answer: answer(question, values) } });
    }
  });
  stream.write({ jobId });
  return stream;
}

function answer(question, values) {
  const given = question.dialog.fields.filter((field) => values.has(field.variable));
  const typed = (field, text) =>
    field.kind === "check" ? { flag: text === "true" } : field.kind === "number" ? { number: Number(text) } : { text };
  return { values: Object.fromEntries(given.map((f) => [f.variable, typed(f, values.get(f.variable))])) };
}

/** Saves the merged listing of all channels. */
async function save(server, jobId, file) {
  const chunks = [];
  for await (const { data } of server.results.GetListing({ jobId }, metadata())) {
    chunks.push(data);
  }
  fs.writeFileSync(file, Buffer.concat(chunks));
}

async function main() {
  const { values: options, positionals: programs } = parseArgs({
    allowPositionals: true,
    options: {
      server: { type: "string", default: process.env.COUNTERPOINT_SERVER || "http://127.0.0.1:7878" },
      machine: { type: "string", default: "fanuc-mill" },
      listing: { type: "string", default: "job.lce" },
      set: { type: "string", multiple: true, default: [] },
      help: { type: "boolean", default: false },
    },
  });
  if (options.help) {
    console.log(USAGE);
    return 0;
  }
  if (programs.length === 0) {
    throw new Error("name at least one program; they are assigned to the channels from left to right");
  }
  const values = new Map(options.set.map((text) => [text.split("=", 1)[0], text.slice(text.indexOf("=") + 1)]));
  const server = await connect(options.server);
  try {
    const job = await submit(server, options.machine, programs);
    console.error(`job ${job}`);
    const attended = attend(server, job, values);
    const ended = await watch(server, job);
    attended.end();
    console.log(`${ended.state.replace("JOB_STATE_", "")} after ${(Math.round(ended.makespanNs / 1e6) / 1e3).toFixed(3)} s of machine time`);
    if (ended.error) {
      throw new Error(ended.error);
    }
    if (ended.firstError) {
      const { file, line, number, text } = ended.firstError;
      console.error(`first error: ${file}:${line}: ${number} ${text}`);
    }
    await save(server, job, options.listing);
    return ended.state === "JOB_STATE_SUCCEEDED" ? 0 : 1;
  } finally {
    server.jobs.close();
  }
}

main().then(
  (code) => (process.exitCode = code),
  (error) => {
    const refusal = grpc.status[error.code];
    console.error(refusal ? sentence(error) : error.message);
    const ofServer = error instanceof Unreachable || (refusal && !OF_REQUEST.includes(refusal));
    process.exitCode = ofServer ? 3 : 2;
  },
);
