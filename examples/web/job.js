// A job over gRPC-Web: submit, watch, dialogs, listing. Every request is a single message, because browsers cannot
// stream requests.

import { Code, ConnectError, createClient } from "@connectrpc/connect";
import { createGrpcWebTransport } from "@connectrpc/connect-web";
import { Blobs } from "./gen/counterpoint/v1/blobs_pb.js";
import { JobState, Jobs, WatchLevel } from "./gen/counterpoint/v1/jobs_pb.js";
import { Operator } from "./gen/counterpoint/v1/operator_pb.js";
import { Results } from "./gen/counterpoint/v1/results_pb.js";

export { JobState };

/** Largest content of PutBlob, bytes. */
const LARGEST = 1 << 20;
/** Longest time for the first answer, ms. */
const REACH_MS = 1500;

/** The clients of a server, for example `http://127.0.0.1:7878`. Fails within REACH_MS if no server answers. */
export async function connect(baseUrl, token) {
  const authorize = (next) => (request) => {
    if (token) {
      request.header.set("authorization", `Bearer ${token}`);
    }
    return next(request);
  };
  const transport = createGrpcWebTransport({ baseUrl, interceptors: [authorize] });
  const clients = {
    blobs: createClient(Blobs, transport),
    jobs: createClient(Jobs, transport),
    operator: createClient(Operator, transport),
    results: createClient(Results, transport),
  };
  try {
    await clients.blobs.findMissing({}, { timeoutMs: REACH_MS });
  } catch (error) {
    const reason = ConnectError.from(error);
    const lost = [Code.Unavailable, Code.DeadlineExceeded, Code.Unknown, Code.Canceled];
    if (!lost.includes(reason.code)) {
      throw reason;
    }
    const text =
      `no server with gRPC-Web answers at ${baseUrl}: check the address, start counterpointd with --grpc-web, ` +
      `and list the origin of this page in --grpc-web-origins`;
    throw Object.assign(new Error(text), { unreachable: true });
  }
  return clients;
}

/** An error as a sentence: the server's message names the fault and the remedy. */
export function sentence(error) {
  if (!(error instanceof ConnectError)) {
    return error.message;
  }
  switch (error.code) {
    case Code.Unavailable:
    case Code.Unknown:
      // A refusal of the server has details; a lost connection has none.
      return error.details.length > 0
        ? `${error.rawMessage}: try again later`
        : "the connection to the server was lost: check that counterpointd is running, then try again";
    case Code.Unauthenticated:
      return `${error.rawMessage}: give a token for this server`;
    default:
      return error.rawMessage;
  }
}

/** Stores the files, `[{ name, bytes }]`, and submits them as channels from left to right. Returns the job id. */
export async function submit({ blobs, jobs }, machine, files) {
  const large = files.find(({ bytes }) => bytes.length > LARGEST);
  if (large) {
    throw new Error(`${large.name} has more than 1 MiB: submit it with another client, which uploads in chunks`);
  }
  const stored = await Promise.all(files.map(({ bytes }) => blobs.putBlob({ data: bytes })));
  // The same request id gives the same job, so the submit may be repeated after a lost answer.
  const { status } = await jobs.submitJob({
    requestId: crypto.randomUUID(),
    machine,
    programs: files.map(({ name }) => ({ path: name })),
    files: files.map(({ name }, at) => ({ path: name, digest: stored[at].digest })),
    options: { attended: true },
  });
  return status.jobId;
}

/** The first error of a failed job with its place, or an empty string. */
export function firstError({ firstError: error }) {
  return error ? `first error: ${error.file}:${error.line}: ${error.number} ${error.text}` : "";
}

/** Shows progress and events until the job ends; continues a broken watch at its cursor. Returns the status. */
export async function watch({ jobs }, jobId, { progress, event }) {
  let afterSeq = 0n;
  for (let failures = 0; ; failures++) {
    try {
      for await (const { content } of jobs.watchJob({ jobId, afterSeq, level: WatchLevel.DIAGNOSTICS })) {
        failures = 0;
        switch (content.case) {
          case "batch":
            content.value.events.forEach(event);
            afterSeq = content.value.lastSeq;
            break;
          case "progress":
            progress(content.value.channels, content.value.cancelRequested);
            break;
          case "ended":
            return content.value;
        }
      }
    } catch (error) {
      const { code } = ConnectError.from(error);
      if (![Code.Unavailable, Code.Unknown].includes(code) || failures >= 10) {
        throw error;
      }
    }
    const pause = Math.min(100 * 2 ** failures, 10_000) * (0.5 + Math.random() / 2);
    await new Promise((resolve) => setTimeout(resolve, pause));
  }
}

/** Calls `ask` for each dialog of a job. `ask` returns values by macro variable, or nothing to decline. */
export async function attend({ operator }, jobId, ask) {
  for await (const { content } of operator.watchQuestions({ jobId })) {
    if (content.case === "question") {
      const question = content.value;
      const values = await ask(question);
      await operator.answerQuestion({ jobId, questionId: question.id, answer: values && answer(question, values) });
    }
  }
}

function answer(question, values) {
  const given = question.dialog.fields.filter((field) => Object.hasOwn(values, field.variable));
  const typed = (kind, text) =>
    kind === "check"
      ? { case: "flag", value: text === "true" }
      : kind === "number"
        ? { case: "number", value: Number(text) }
        : { case: "text", value: text };
  return { values: Object.fromEntries(given.map((f) => [f.variable, { value: typed(f.kind.case, values[f.variable]) }])) };
}

/** The merged listing of all channels. */
export async function listing({ results }, jobId) {
  const decoder = new TextDecoder();
  let text = "";
  for await (const { data } of results.getListing({ jobId })) {
    text += decoder.decode(data, { stream: true });
  }
  return text + decoder.decode();
}
