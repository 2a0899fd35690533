package main

// Makes the package v1 from the contract. The import path is that of go_package in the .proto files.
//
//go:generate sh -c "protoc -I ../../proto --go_out=. --go_opt=module=counterpoint --go-grpc_out=. --go-grpc_opt=module=counterpoint ../../proto/counterpoint/v1/*.proto"
