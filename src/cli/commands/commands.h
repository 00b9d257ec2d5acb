#pragma once

#include <memory>

#include "lsmvs/program/command.h"

// Makers of the commands: each is defined in the file of its name in this folder.

namespace lsmvs {

// lsmvs-mesher, a program of its own.
std::unique_ptr<Command> MakeMesherCommand();

std::unique_ptr<Command> MakeQuasiDenseMatcher();
std::unique_ptr<Command> MakePatchMatchStereoCommand();
std::unique_ptr<Command> MakeStereoFusionCommand();
std::unique_ptr<Command> MakeVisibilityMesherCommand();
std::unique_ptr<Command> MakeMeshRefinerCommand();
std::unique_ptr<Command> MakeMeshTexturerCommand();
std::unique_ptr<Command> MakeMeshSimplifier();
std::unique_ptr<Command> MakeMeshComparer();
std::unique_ptr<Command> MakeMeshEvaluator();
std::unique_ptr<Command> MakeMeshExporter();
std::unique_ptr<Command> MakeMeshMerger();
std::unique_ptr<Command> MakeMeshRenderer();
std::unique_ptr<Command> MakeMapConverter();
std::unique_ptr<Command> MakeRunStatusCommand();
// Part of runs on many machines; not for people.
std::unique_ptr<Command> MakeRunTaskCommand();

}  // namespace lsmvs
