// Checks the types of packages as they are on other systems, tests included.
//
// usage: systems PACKAGE...
//
// `GOOS=windows go vet` does that, too, but compiles gRPC and most of the standard library first: half a minute for each system.
package main

import (
	"fmt"
	"go/ast"
	"go/build"
	"go/importer"
	"go/parser"
	"go/token"
	"go/types"
	"os"
	"path/filepath"
)

func main() {
	failures := 0
	for _, system := range []string{"darwin", "windows"} {
		build.Default.GOOS, build.Default.CgoEnabled = system, false
		files := token.NewFileSet()
		checker := types.Config{
			Importer: importer.ForCompiler(files, "source", nil),
			Error:    func(err error) { fmt.Printf("%s: %v\n", system, err); failures++ },
		}
		count := 0
		for _, path := range os.Args[1:] {
			count += check(&checker, files, path)
		}
		fmt.Printf("%s: %d files\n", system, count)
	}
	if failures > 0 {
		os.Exit(1)
	}
}

// check returns how many files the package has there.
func check(checker *types.Config, files *token.FileSet, path string) int {
	found, err := build.Import(path, "", 0)
	if err != nil {
		checker.Error(err)
		return 0
	}
	parsed := []*ast.File{}
	for _, name := range append(found.GoFiles, found.TestGoFiles...) {
		file, err := parser.ParseFile(files, filepath.Join(found.Dir, name), nil, 0)
		if err != nil {
			checker.Error(err)
			return 0
		}
		parsed = append(parsed, file)
	}
	_, _ = checker.Check(path, files, parsed, nil) // errors are counted by checker.Error
	return len(parsed)
}
