// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// The systems that the paper compares with, beside ours: what evaluate calls.

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_BASELINES_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_BASELINES_HPP

#include "gradboost.hpp"
#include "options.hpp"
#include "peers.hpp"
#include "reiter2012.hpp"
#include "reiter2014.hpp"
#include "run.hpp"
#include "../result.hpp"

namespace evaluation {

class Baselines
{
public:
    //! @param folder of models
    Baselines(const BaselineOptions& options, const String& folder) : options_(options), folder_(folder) {}

    //! What other baselines make another result of a sequence; it names the models.
    String settings(const String& sequence)
    {
        if (options_.names.empty())
            return String();
        makeTraining(sequence);
        return options_.text() + (training_ ? " " + training_->print() : String());
    }

    //! Adds runs and counts. @param sequence its folder
    void evaluate(const String& sequence, const Data& data, int frames, Result& result)
    {
        if (options_.names.empty())
            return;
        makeTraining(sequence);
        learn();
        if (options_.has("gradboost") || options_.has("reiter2014"))
            countClasses(data, frames, result);
        if (options_.has("reiter2014"))
        {
            say(data, "reiter2014");
            result.runs.push_back(ReiterFusion(data, *forest_).track(frames, options_.quiet));
        }
        if (options_.has("reiter2012"))
        {
            say(data, "reiter2012");
            result.runs.push_back(WholeTool(data, materials_.get(), options_.fine).track(frames, options_.quiet));
        }
        for (size_t i = 0; i < options_.names.size(); i++)
            if (options_.names[i] == "contour" || options_.names[i] == "rapid")
            {
                say(data, options_.names[i].c_str());
                result.runs.push_back(trackEdges(data, options_.names[i], frames, options_.quiet));
            }
    }

private:
    void say(const Data& data, const char* what) const
    {
        if (!options_.quiet)
            std::fprintf(stderr, "%s: %s\n", data.label.c_str(), what);
    }
    void makeTraining(const String& sequence)
    {
        const std::vector<String> folders = options_.trainingFor(sequence);
        if (folders == folders_)   // none, too: then nothing learns
            return;
        folders_ = folders;
        training_ = makePtr<Training>(folders);
        gradboost_.release();
        forest_.release();
        materials_.release();
    }
    template <class Learner> void prepareOnce(Ptr<Learner>& learner, const Ptr<Learner>& fresh)
    {
        if (learner)
            return;
        learner = fresh;
        prepare(*learner, *training_, folder_, options_.quiet);
    }
    void learn()
    {
        if (options_.has("gradboost"))
            prepareOnce(gradboost_, makePtr<GradBoost>(options_.parts, options_.rounds, options_.early));
        if (options_.has("reiter2014"))
            prepareOnce(forest_, makePtr<Forest>(training_->classes(), options_.trees));
        if (options_.has("reiter2012") && training_)
            prepareOnce(materials_, makePtr<Materials>());
    }
    void countClasses(const Data& data, int frames, Result& result)
    {
        say(data, "detection of classes of parts");
        ClassRun run(data, options_.parts);
        if (gradboost_)
        {
            run.add(*gradboost_, ClassRun::IMAGE);
            run.add(*gradboost_, ClassRun::WINDOW);
        }
        if (forest_)
            run.add(*forest_, ClassRun::WINDOW);
        result.classes = run.run(frames, options_.quiet);
        if (gradboost_ && !options_.quiet)
            std::fprintf(stderr, "gradboost: %.1f of %d rounds a pixel\n", gradboost_->meanRounds(), gradboost_->rounds());
    }

    BaselineOptions options_;
    String folder_;
    std::vector<String> folders_;   // that training_ is of
    Ptr<Training> training_;
    Ptr<GradBoost> gradboost_;
    Ptr<Forest> forest_;
    Ptr<Materials> materials_;
};

} // namespace evaluation

#endif
