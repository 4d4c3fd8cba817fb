#include "study/study_threads.hpp"

#include <opencv2/core/utility.hpp>

namespace tagcal::study {

OneOpenCvThread::OneOpenCvThread() : before_(cv::getNumThreads()) { cv::setNumThreads(1); }

OneOpenCvThread::~OneOpenCvThread() { cv::setNumThreads(before_); }

}  // namespace tagcal::study
