package main

// Generates the package v1 from the contract. go_package in the .proto files sets the import path.
//
//go:generate sh -c "protoc -I ../../proto --go_out=. --go_opt=module=counterpoint --go-grpc_out=. --go-grpc_opt=module=counterpoint ../../proto/counterpoint/v1/*.proto"
