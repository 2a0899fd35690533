// Submits NC programs to a Counterpoint server, watches them live, answers dialogs, and saves the merged listing.
//
//	go run . -machine fanuc-2path-lathe upper.nc lower.nc
package main

import (
	"context"
	"crypto/rand"
	"crypto/sha256"
	"encoding/hex"
	"errors"
	"flag"
	"fmt"
	"io"
	"os"
	"path/filepath"
	"strconv"
	"strings"
	"time"

	"google.golang.org/grpc"
	"google.golang.org/grpc/codes"
	"google.golang.org/grpc/connectivity"
	"google.golang.org/grpc/credentials/insecure"
	"google.golang.org/grpc/keepalive"
	"google.golang.org/grpc/metadata"
	"google.golang.org/grpc/status"

	v1 "counterpoint/v1"
)

// errUnreachable reports an address where no server answers.
var errUnreachable = errors.New("check the address, or start counterpointd")

func main() {
	server := flag.String("server", "127.0.0.1:7878", "`address` of the server")
	machine := flag.String("machine", "fanuc-mill", "`name` of the machine")
	listing := flag.String("listing", "job.lce", "`file` for the listing")
	values := settings{}
	flag.Var(values, "set", "`NAME=VALUE` for a field of a dialog; may be repeated")
	flag.Parse()
	if flag.NArg() == 0 {
		fmt.Fprintln(os.Stderr, "name at least one program; they are assigned to the channels from left to right")
		os.Exit(2)
	}
	client, err := connect(*server)
	var state v1.JobState
	if err == nil {
		defer client.conn.Close()
		state, err = client.run(*machine, flag.Args(), values, *listing)
	}
	switch {
	case errors.Is(err, errUnreachable):
		fmt.Fprintln(os.Stderr, err)
		os.Exit(3)
	case err != nil:
		fmt.Fprintln(os.Stderr, sentence(err))
		if code := status.Code(err); code == codes.Unavailable || code == codes.Unauthenticated {
			os.Exit(3)
		}
		os.Exit(2)
	case state != v1.JobState_JOB_STATE_SUCCEEDED:
		os.Exit(1)
	}
}

// sentence describes an error: the server's message names the fault and the remedy.
func sentence(err error) string {
	answer, ok := status.FromError(err)
	if !ok {
		return err.Error()
	}
	switch answer.Code() {
	case codes.Unavailable:
		// A refusal of the server has details; a lost connection has none.
		if len(answer.Details()) > 0 {
			return answer.Message() + ": try again later"
		}
		return "the connection to the server was lost: check that counterpointd is running, then try again"
	case codes.Unauthenticated:
		return answer.Message() + ": set COUNTERPOINT_TOKEN to a token for this server"
	default:
		return answer.Message()
	}
}

// settings maps macro variables to values for the fields of dialogs.
type settings map[string]string

func (s settings) String() string { return "" }

func (s settings) Set(text string) error {
	name, value, found := strings.Cut(text, "=")
	if !found {
		return errors.New("expected NAME=VALUE")
	}
	s[name] = value
	return nil
}

type client struct {
	conn *grpc.ClientConn
	ctx  context.Context
}

// connect waits at most 1.5 s for the first connection.
func connect(address string) (*client, error) {
	conn, err := grpc.NewClient(address,
		grpc.WithTransportCredentials(insecure.NewCredentials()),
		grpc.WithKeepaliveParams(keepalive.ClientParameters{Time: 30 * time.Second, Timeout: 10 * time.Second}))
	if err != nil {
		return nil, err
	}
	ctx, cancel := context.WithTimeout(context.Background(), 1500*time.Millisecond)
	defer cancel()
	conn.Connect()
	for state := conn.GetState(); state != connectivity.Ready; state = conn.GetState() {
		if !conn.WaitForStateChange(ctx, state) {
			conn.Close()
			return nil, fmt.Errorf("no server without TLS answers at %s: %w", address, errUnreachable)
		}
	}
	all := context.Background()
	if token := os.Getenv("COUNTERPOINT_TOKEN"); token != "" {
		all = metadata.AppendToOutgoingContext(all, "authorization", "Bearer "+token)
	}
	return &client{conn, all}, nil
}

func (c *client) run(machine string, programs []string, values settings, listing string) (v1.JobState, error) {
	job, err := c.submit(machine, programs)
	if err != nil {
		return 0, err
	}
	fmt.Fprintln(os.Stderr, "job", job)
	go c.attend(job, values)
	ended, err := c.watch(job)
	if err != nil {
		return 0, err
	}
	fmt.Printf("%s after %.3f s of machine time\n",
		strings.TrimPrefix(ended.State.String(), "JOB_STATE_"), float64((ended.MakespanNs+500_000)/1_000_000)/1e3)
	if ended.Error != "" {
		return 0, errors.New(ended.Error)
	}
	if first := ended.FirstError; first != nil {
		fmt.Fprintf(os.Stderr, "first error: %s:%d: %d %s\n", first.File, first.Line, first.Number, first.Text)
	}
	return ended.State, c.save(job, listing)
}

// submit uploads the files that the server does not have and submits the job. It returns once the job is stored.
func (c *client) submit(machine string, programs []string) (string, error) {
	// The same request id gives the same job, so the submit may be repeated after a lost answer.
	request := &v1.SubmitJobRequest{RequestId: rand.Text(), Machine: machine, Options: &v1.JobOptions{Attended: true}}
	blobs, contents := v1.NewBlobsClient(c.conn), map[string][]byte{}
	find := &v1.FindMissingRequest{}
	for _, path := range programs {
		content, err := os.ReadFile(path)
		if err != nil {
			return "", err
		}
		sum := sha256.Sum256(content)
		digest, name := hex.EncodeToString(sum[:]), filepath.Base(path)
		contents[digest] = content
		find.Digests = append(find.Digests, digest)
		request.Programs = append(request.Programs, &v1.Program{Path: name})
		request.Files = append(request.Files, &v1.FileRef{Path: name, Digest: digest})
	}
	missing, err := blobs.FindMissing(c.ctx, find)
	if err != nil {
		return "", err
	}
	for _, digest := range missing.Digests {
		if err := upload(c.ctx, blobs, digest, contents[digest]); err != nil {
			return "", err
		}
	}
	answer, err := v1.NewJobsClient(c.conn).SubmitJob(c.ctx, request)
	if err != nil {
		return "", err
	}
	return answer.Status.JobId, nil
}

// upload sends content in chunks.
func upload(ctx context.Context, blobs v1.BlobsClient, digest string, content []byte) error {
	const chunk = 64 << 10
	stream, err := blobs.Upload(ctx)
	if err != nil {
		return err
	}
	size := uint64(len(content))
	part := &v1.UploadRequest{Digest: digest, Size: &size}
	for first := true; first || len(content) > 0; first = false {
		part.Data, content = content[:min(chunk, len(content))], content[min(chunk, len(content)):]
		// The answer contains the reason for a refusal.
		if stream.Send(part) != nil {
			break
		}
		part = &v1.UploadRequest{}
	}
	_, err = stream.CloseAndRecv()
	return err
}

// watch prints diagnostics as they occur until the job ends. After a broken stream it continues at its cursor.
func (c *client) watch(job string) (*v1.JobStatus, error) {
	request := &v1.WatchJobRequest{JobId: job, Level: v1.WatchLevel_WATCH_LEVEL_DIAGNOSTICS}
	for failures := 0; ; failures++ {
		stream, err := v1.NewJobsClient(c.conn).WatchJob(c.ctx, request)
		var message *v1.WatchJobResponse
		for err == nil {
			if message, err = stream.Recv(); err != nil {
				break
			}
			failures = 0
			switch content := message.Content.(type) {
			case *v1.WatchJobResponse_Batch:
				for _, event := range content.Batch.Events {
					show(event)
				}
				request.AfterSeq = content.Batch.LastSeq
			case *v1.WatchJobResponse_Progress:
				for _, channel := range content.Progress.Channels {
					fmt.Fprintf(os.Stderr, "%s: %.0f %%, block %d\n", channel.Name, channel.Percent, channel.Blocks)
				}
			case *v1.WatchJobResponse_Ended:
				return content.Ended, nil
			}
		}
		if status.Code(err) != codes.Unavailable || failures >= 10 {
			return nil, err
		}
		time.Sleep(min(100*time.Millisecond<<failures, 10*time.Second))
	}
}

func show(event *v1.Event) {
	if diagnostic := event.GetDiagnostic(); diagnostic != nil {
		fmt.Printf("channel %d line %d: %d %s\n", event.Channel, event.Line, diagnostic.Number, diagnostic.Text)
	}
}

// attend answers every dialog with its first button of type OK and the values of the command line.
func (c *client) attend(job string, values settings) {
	stream, err := v1.NewOperatorClient(c.conn).Attend(c.ctx)
	if err == nil {
		err = stream.Send(&v1.AttendRequest{Content: &v1.AttendRequest_JobId{JobId: job}})
	}
	var message *v1.AttendResponse
	for err == nil {
		if message, err = stream.Recv(); err != nil {
			break
		}
		question := message.GetQuestion()
		if question == nil {
			continue
		}
		fmt.Printf("dialog '%s': %s\n", question.Dialog.Name, question.Dialog.Title)
		reply := &v1.AttendRequest{}
		if answer, wrong := answer(question, values); wrong != nil || question.Problem != "" {
			fmt.Fprintln(os.Stderr, "declined:", question.Problem, wrong)
			reply.Content = &v1.AttendRequest_Declined{Declined: question.Id}
		} else {
			reply.Content = &v1.AttendRequest_Answer{Answer: &v1.QuestionAnswer{QuestionId: question.Id, Answer: answer}}
		}
		err = stream.Send(reply)
	}
	if !errors.Is(err, io.EOF) {
		fmt.Fprintln(os.Stderr, "dialogs are no longer answered:", sentence(err))
	}
}

func answer(question *v1.Question, values settings) (*v1.DialogAnswer, error) {
	answer := &v1.DialogAnswer{Values: map[string]*v1.DialogValue{}}
	for _, field := range question.Dialog.Fields {
		text, given := values[field.Variable]
		if !given {
			continue
		}
		value := &v1.DialogValue{}
		switch field.Kind.(type) {
		case *v1.DialogField_Check:
			flag, err := strconv.ParseBool(text)
			if err != nil {
				return nil, fmt.Errorf("%s must be true or false, not %q", field.Variable, text)
			}
			value.Value = &v1.DialogValue_Flag{Flag: flag}
		case *v1.DialogField_Number:
			number, err := strconv.ParseFloat(text, 64)
			if err != nil {
				return nil, fmt.Errorf("%s must be a number, not %q", field.Variable, text)
			}
			value.Value = &v1.DialogValue_Number{Number: number}
		default:
			value.Value = &v1.DialogValue_Text{Text: text}
		}
		answer.Values[field.Variable] = value
	}
	return answer, nil
}

// save writes the merged listing of all channels.
func (c *client) save(job, path string) error {
	stream, err := v1.NewResultsClient(c.conn).GetListing(c.ctx, &v1.GetListingRequest{JobId: job})
	if err != nil {
		return err
	}
	file, err := os.Create(path)
	if err != nil {
		return err
	}
	for {
		chunk, err := stream.Recv()
		if errors.Is(err, io.EOF) {
			return file.Close()
		}
		if err == nil {
			_, err = file.Write(chunk.Data)
		}
		if err != nil {
			file.Close()
			return err
		}
	}
}
