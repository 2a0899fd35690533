// Submits NC programs to a Counterpoint server, follows them over broken connections and saves the summary.
//
//   dotnet run -- http://127.0.0.1:7878 fanuc-mill part.nc

using System.Security.Cryptography;
using Counterpoint.V1;
using Google.Protobuf;
using Grpc.Core;
using Grpc.Net.Client;

if (args.Length < 3)
{
    Console.Error.WriteLine("usage: dotnet run -- ADDRESS MACHINE PROGRAM...");
    return 2;
}

using var channel = GrpcChannel.ForAddress(args[0], new GrpcChannelOptions
{
    HttpHandler = new SocketsHttpHandler
    {
        KeepAlivePingDelay = TimeSpan.FromSeconds(30),
        KeepAlivePingTimeout = TimeSpan.FromSeconds(10),
    },
});
var headers = new Metadata();
if (Environment.GetEnvironmentVariable("COUNTERPOINT_TOKEN") is { } token)
{
    headers.Add("authorization", $"Bearer {token}");
}

var jobs = new Jobs.JobsClient(channel);
var blobs = new Blobs.BlobsClient(channel);
var results = new Results.ResultsClient(channel);

try
{
    return await Run();
}
catch (RpcException error)
{
    Console.Error.WriteLine(Sentence(error));
    return error.StatusCode is StatusCode.Unavailable or StatusCode.Unauthenticated ? 3 : 2;
}
catch (Exception error) when (error is IOException or UnauthorizedAccessException)
{
    Console.Error.WriteLine(error.Message);
    return 2;
}

// The server's message names the fault and the remedy.
static string Sentence(RpcException error) => error.StatusCode switch
{
    // A refusal of the server has details; a lost connection has none.
    StatusCode.Unavailable when error.Trailers.Any(entry => entry.Key == "grpc-status-details-bin") =>
        $"{error.Status.Detail}: try again later",
    StatusCode.Unavailable =>
        "no connection to the server: check the address (http or https), the certificates, "
            + "and that counterpointd is running",
    StatusCode.Unauthenticated => $"{error.Status.Detail}: set COUNTERPOINT_TOKEN to a token for this server",
    _ => error.Status.Detail,
};

async Task<int> Run()
{
    // The request id makes the submit safe to repeat: the same id gives the same job.
    var request = new SubmitJobRequest { RequestId = Guid.NewGuid().ToString(), Machine = args[1] };
    foreach (var path in args.Skip(2))
    {
        var content = await File.ReadAllBytesAsync(path);
        var digest = Convert.ToHexString(SHA256.HashData(content)).ToLowerInvariant();
        request.Programs.Add(new Counterpoint.V1.Program { Path = Path.GetFileName(path) });
        request.Files.Add(new FileRef { Path = Path.GetFileName(path), Digest = digest });
        var question = new FindMissingRequest();
        question.Digests.Add(digest);
        if ((await blobs.FindMissingAsync(question, headers)).Digests.Count == 0)
        {
            continue;
        }
        using var upload = blobs.Upload(headers);
        const int chunk = 64 * 1024;
        for (var at = 0; at == 0 || at < content.Length; at += chunk)
        {
            var data = ByteString.CopyFrom(content, at, Math.Min(chunk, content.Length - at));
            var part = new UploadRequest { Data = data };
            if (at == 0)
            {
                part.Digest = digest;
                part.Size = (ulong)content.Length;
            }
            await upload.RequestStream.WriteAsync(part);
        }
        await upload.RequestStream.CompleteAsync();
        await upload;
    }

    var job = (await jobs.SubmitJobAsync(request, headers)).Status.JobId;
    Console.Error.WriteLine($"job {job}");
    var status = await Follow(job);
    Console.WriteLine($"{status.State} after {(status.MakespanNs + 500_000) / 1_000_000 / 1e3:F3} s of machine time");
    if (status.Error != "")
    {
        Console.Error.WriteLine(status.Error);
        return 1;
    }
    if (status.FirstError is { } first)
    {
        Console.Error.WriteLine($"first error: {first.File}:{first.Line}: {first.Number} {first.Text}");
    }
    using var summary = results.GetSummary(new GetSummaryRequest { JobId = job }, headers);
    await using var file = File.Create("summary.json");
    await foreach (var part in summary.ResponseStream.ReadAllAsync())
    {
        part.Data.WriteTo(file);
    }
    return status.State == JobState.Succeeded ? 0 : 1;
}

// Every event once: after a broken stream the watch continues at its cursor.
async Task<JobStatus> Follow(string id)
{
    ulong cursor = 0;
    for (var failures = 0; ; failures++)
    {
        try
        {
            var watch = new WatchJobRequest { JobId = id, AfterSeq = cursor, Level = WatchLevel.Diagnostics };
            using var stream = jobs.WatchJob(watch, headers);
            await foreach (var message in stream.ResponseStream.ReadAllAsync())
            {
                failures = 0;
                switch (message.ContentCase)
                {
                    case WatchJobResponse.ContentOneofCase.Batch:
                        foreach (var e in message.Batch.Events.Where(e => e.Seq > cursor && e.Diagnostic is not null))
                        {
                            Console.WriteLine($"channel {e.Channel} line {e.Line}: {e.Diagnostic.Number} {e.Diagnostic.Text}");
                        }
                        cursor = Math.Max(cursor, message.Batch.LastSeq);
                        break;
                    case WatchJobResponse.ContentOneofCase.Ended:
                        return message.Ended;
                }
            }
        }
        catch (RpcException error) when (error.StatusCode == StatusCode.Unavailable && failures < 10)
        {
            await Task.Delay(TimeSpan.FromMilliseconds(Math.Min(100 << failures, 10_000) * (0.5 + Random.Shared.NextDouble() / 2)));
        }
    }
}
